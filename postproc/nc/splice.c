/* Text with its edits made, once more in C: what nc/splice.py puts together of the same edits, and
   the numbers as nc/numbers.py writes them. Knows bytes and whole numbers only. */
#include <stdint.h>
#include <string.h>

typedef int64_t whole;

enum { LISTS = 32, ROOM = 24 /* bytes of a number and more */ };

/* n edits: in the place of text[start..stop] come `size` bytes of the pool from `at` on and, where
   decimals are not negative, less the zeros among them and with value / 10^decimals behind. */
typedef struct { whole n; const whole *start, *stop, *rank, *at, *size, *value, *decimals; } Edits;

/* Lists of edits of a text; written: how many bytes out then has, -1: a list is not in order, or
   there are too many. */
typedef struct {
    whole lists, length, written;
    const Edits *list;
    const char *text, *pool;
    char *out;
} Splicing;

/* numbers.decimal_text; where it ends. ROOM bytes are there. */
static char *number(char *to, whole value, whole decimals)
{
    char digits[2 * ROOM] = {0}, *begin = digits + ROOM;
    uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    for (whole k = 0; k <= decimals || rest; k++, rest /= 10) {
        if (k == decimals) *--begin = '.';
        *--begin = (char)('0' + rest % 10);
    }
    if (value < 0) *--begin = '-';
    memcpy(to, begin, ROOM);
    return to + (digits + ROOM - begin);
}

/* The new text of an edit, of which some is `new`; where it ends */
static char *put(char *to, const Edits *e, whole k, const char *new)
{
    const whole size = e->size[k];
    if (e->decimals[k] < 0) return (char *)memcpy(to, new, (size_t)size) + size;
    for (whole b = 0; b < size; b++) {
        *to = new[b];
        to += new[b] != 0;
    }
    return number(to, e->value[k], e->decimals[k]);
}

/* What stays of the text between two edits: two words that go may take the blank between them
   along. Where it ends */
static char *kept(char *to, const char *text, whole from, whole until)
{
    if (until <= from) return to;
    return (char *)memcpy(to, text + from, (size_t)(until - from)) + (until - from);
}

/* The next edit of a list */
typedef struct { whole list, place, rank, at; } Next;

/* What is put in at a place stands before what is taken out from there on. */
static Next edit(const Splicing *w, whole list, whole k)
{
    const Edits *e = w->list + list;
    if (k == e->n) return (Next){.list = list, .place = INT64_MAX, .at = k};
    return (Next){list, 2 * e->start[k] + (e->stop[k] > e->start[k]), e->rank[k], k};
}

/* Of two at one place with one rank, the one of the list before */
static int before(const Next *one, const Next *other)
{
    if (one->place != other->place) return one->place < other->place;
    if (one->rank != other->rank) return one->rank < other->rank;
    return one->list < other->list;
}

/* Put the next edit of a list among n others, which are in order behind the place before them. */
static void sorted(Next *others, whole n, Next next)
{
    whole k = 0;
    for (; k < n && before(others + k, &next); k++) others[k - 1] = others[k];
    others[k - 1] = next;
}

/* Splice.result */
void splice(Splicing *w)
{
    Next next[LISTS];
    char *to = w->out;
    whole last = 0;
    w->written = -1;
    if (w->lists > LISTS) return;
    for (whole i = 0; i < w->lists; i++) sorted(next + LISTS - i, i, edit(w, w->lists - 1 - i, 0));
    Next *first = next + LISTS - w->lists;
    while (first->place < INT64_MAX) {
        const Edits *e = w->list + first->list;
        const Next now = *first, then = edit(w, now.list, now.at + 1);
        to = kept(to, w->text, last, e->start[now.at]);
        to = put(to, e, now.at, w->pool + e->at[now.at]);
        last = e->stop[now.at];
        if (before(&then, &now)) return;
        sorted(first + 1, w->lists - 1, then);
    }
    w->written = kept(to, w->text, last, w->length) - w->out;
}
