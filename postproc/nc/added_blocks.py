"""Blocks that are put in behind one that was cut: what surrounds their words, and the M codes that
act behind the last of them."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import RAPID, THREAD
from postproc.nc import codes
from postproc.nc.columns import one_of
from postproc.nc.numbers import POWERS
from postproc.nc.writing import Writing


def codes_after_motion(b: Writing) -> None:
    """M codes that act after the motion go to its last piece."""
    m, w = b.m, b.w
    named = (w.letter == ord("M")).nonzero()[0]
    if not len(named):
        return
    #   G1 X9 M5, cut at X3    G1 X3      M5 acts when the block's motion is done: at its place it
    #                          X9 M5      would stop the spindle at X3.
    cut = np.zeros(w.blocks, bool)
    cut[m.block[b.p.motion[b.several]]] = True
    # and so does what ends the program, or begins it again: M99 of Fanuc, M17 of Siemens
    ends = (*codes.AFTER_MOTION, *b.dialect.ends, *b.dialect.restarts)
    late = np.isin(w.mantissa[named], ends) & (w.decimals[named] == 0)
    for word in named[late & cut[w.block[named]]]:
        motion = int(np.searchsorted(m.block, w.block[word]))
        last = int((b.p.motion == motion).nonzero()[0][-1])
        text = w.text[w.start[word] : w.stop[word]]
        start = int(w.start[word])
        # with the blank before it, or two would be left
        start -= start > w.block_start[w.block[word]] and w.text[start - 1 : start] == b" "
        b.splice.texts([start], [w.stop[word]], [0], [b""])
        at = int(b.behind(motion))
        b.splice.texts(
            [at],
            [at],
            [int(b.rank(np.array([last]))[0]) + 60],
            [(b" " if b.spaced[motion] else b"") + text],
        )


def _plain_lead(k: int) -> bytes:
    """What an added block begins with, by 2 * its code + block delete, from -2 (no code) on."""
    return (b"/" if k % 2 else b"") + (b"G%d" % (k // 2) if k >= 0 else b"")


def _klartext_lead(k: int) -> bytes:
    return b"/ L" if k % 2 else b"L"


def frames_of_blocks(b: Writing, added: np.ndarray) -> None:
    """What surrounds the words of an added block: line ends, block delete, a code that
    changed."""
    m, p, w = b.m, b.p, b.w
    motion = p.motion[added]
    block = m.block[motion]
    stop, rank, at = w.block_stop[block], b.rank(added), b.behind(motion)
    marks = [ord(mark) for mark in (";", b.dialect.block_end) if mark]
    # it ends with its line, as nearly all do
    line = (stop < len(w.text)) & ~one_of(b.byte.take(stop), marks)
    # each block ends as its own line does, also where a file mixes LF and CR LF
    returns = (b.byte.take(np.maximum(stop - 1, 0)) == ord("\r")) & (stop > 0)
    skip, code = w.skip[block], np.where(b.names_code[added], p.code[added] + b.above[motion], -1)
    thread = b.names_code[added] & (p.code[added] == THREAD)
    if any_of(thread):  # G32 G33
        word = m.code_word[motion[thread]]
        code[thread] = w.mantissa[word] // POWERS[w.decimals[word]]
    lead_of = _plain_lead
    if b.klartext:
        lead_of = _klartext_lead
        fast = p.code[added] == RAPID
        b.splice.constants(at[fast], at[fast], rank[fast] + 50, b" FMAX")
    kind = 2 * code + skip
    for k in sorted(set(kind[line].tolist())):
        lead = lead_of(k)
        if lead:
            which = line & (kind == k)
            b.splice.constants(at[which], at[which], rank[which], lead)
    for text, which in ((b"\r\n", line & returns), (b"\n", line & ~returns)):
        b.splice.constants(at[which], at[which], rank[which] + 90, text)
    leads: list[bytes] = []
    tails: list[bytes] = []
    others = (~line).nonzero()[0]
    for k in others:
        before, after = _ends(b, int(stop[k]))
        leads.append(before + lead_of(int(kind[k])))
        tails.append(after)
    b.splice.texts(at[others], at[others], rank[others], leads)
    b.splice.texts(at[others], at[others], rank[others] + 90, tails)


def _ends(b: Writing, stop: int) -> tuple[bytes, bytes]:
    """What stands before and behind an added block, after a block that ends at `stop`: at the
    end of the text, or with a mark of its own."""
    text = b.w.text
    if stop >= len(text):
        return b.state.newline or b"\n", b""
    # " ;" or "*": the blank before the mark belongs to it
    mark = text[stop - (text[stop - 1 : stop] == b" ") : stop + 1]
    line_end = text.find(b"\n", stop)
    rest = text[stop + 1 : line_end if line_end >= 0 else len(text)]
    if rest.strip():
        return b" ", mark
    if line_end < 0:
        return b.state.newline or b"\n", mark
    return b"\r\n" if rest.endswith(b"\r") else b"\n", mark
