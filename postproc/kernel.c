/* What numpy takes longest for, once more in C: looking at a table, and cutting arcs. The same
   operations in the same order as in machine/tables.py (look), compensate/samples.py (lay, aim),
   compensate/fit.py and compensate/prove.py (the others), so the same bits; no compiler option may change that
   (kernel.py). Positions are mm and int64 ticks; tables (A, R) lie row behind row. */
#include <math.h>
#include <stdint.h>

typedef int64_t whole;

const char source[] = SOURCE; /* by which kernel.py knows it */

#define TICKS 1e10            /* per mm */
#define TURN 6.283185307179586
#define EXACT 1e-9            /* mm */
#define SAME_ANGLE 1e-9       /* rad: below what two ends one tick apart make */
#define NOTHING 1e-30         /* mm */
#define WIDEST 6.2            /* rad: nearly a turn, and more, is left to fit.py */

enum { AXES = 16, FITTED = 5, LONGEST = 512 /* samples of a row */, NEARLY = 100, FLAT = 16 };
static const whole fitted[FITTED] = {3, 5, 8, 11, 13}; /* sixteenths of a run */

static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* Columns (C, n) of a table at n places: base + rise (C, intervals) times the share of the
   interval. Nodes are 1 / per mm apart; even: so is the last one. */
void look(whole n, const double *at, whole intervals, const double *nodes, const double *width,
          double per, whole even, whole C, const double *base, const double *rise, double *out)
{
    const whole last = intervals - 1;
    for (whole k = 0; k < n; k++) {
        double share;
        whole i;
        if (even) {
            double place = smaller(larger((at[k] - nodes[0]) * per, 0.0), (double)intervals);
            i = (whole)place < last ? (whole)place : last;
            share = place - (double)i;
        } else {
            double inside = smaller(larger(at[k], nodes[0]), nodes[intervals]);
            i = (whole)((inside - nodes[0]) * per);
            i = i < last ? i : last;
            while (i > 0 && inside < nodes[i]) i--;
            while (i < last && inside >= nodes[i + 1]) i++;
            share = (inside - nodes[i]) / width[i];
        }
        for (whole c = 0; c < C; c++)
            out[c * n + k] = rise[c * intervals + i] * share + base[c * intervals + i];
    }
}

/* Samples of R plain rows in one plane, as compensate/laid.py lays them out: count of each row, from
   its first stretch on. */
typedef struct {
    whole rows, samples, axes, first, second;
    double bent;
    const whole *stretch, *count, *parts;
    const double *way, *step, *t0, *t1, *angle, *sweep, *radius, *grown;
    const double *centre, *start, *travel, *shift;                               /* (..., R) */
    double *tangent, *t, *smooth, *unit, *wide, *nominal, *guess;                /* (..., N) */
} Laying;

/* samples.laid: where on the arc they lie, and half of their angles in the place of tangents. */
void lay(const Laying *w)
{
    for (whole r = 0, k = 0; r < w->rows; r++) {
        const whole last = k + w->count[r] - 1;
        for (whole g = w->stretch[r]; k < last; g++)
            for (whole i = 0; i < w->parts[g]; i++, k++) {
                w->t[k] = w->step[g] * (double)i + w->way[g];
                w->smooth[k] = i ? w->bent : 0.0;
            }
        w->t[k] = w->t1[r];
        w->smooth[k++] = 0.0;
        for (whole i = k - w->count[r]; i < k; i++)
            w->tangent[i] = (w->sweep[r] * w->t[i] + w->angle[r]) * 0.5;
    }
}

/* samples.laid: directions, radii, places and what is foreseen of their commands. */
void aim(const Laying *w)
{
    const whole R = w->rows, N = w->samples;
    for (whole r = 0, k = 0; r < R; k += w->count[r++]) {
        const whole n = w->count[r];
        const double *t = w->t + k, *tangent = w->tangent + k, way = w->t1[r] - w->t0[r];
        double *unit[2] = {w->unit + k, w->unit + N + k}, *wide = w->wide + k;
        for (whole i = 0; i < n; i++) {
            const double share = 2.0 / (tangent[i] * tangent[i] + 1.0);
            unit[0][i] = share - 1.0;
            unit[1][i] = tangent[i] * share;
            wide[i] = w->grown[r] * t[i] + w->radius[r];
        }
        for (whole a = 0; a < w->axes; a++) {
            const whole own = a * R + r;
            const double from = w->shift[own], more = w->shift[w->axes * R + own] - from;
            double *nominal = w->nominal + a * N + k, *guess = w->guess + a * N + k;
            for (whole i = 0; i < n; i++) {
                nominal[i] = w->travel[own] * t[i] + w->start[own];
                guess[i] = more * ((t[i] - w->t0[r]) / way) + from;
            }
        }
        for (int p = 0; p < 2; p++) {
            double *nominal = w->nominal + (p ? w->second : w->first) * N + k;
            for (whole i = 0; i < n; i++)
                nominal[i] = wide[i] * unit[p][i] + w->centre[p * R + r];
        }
    }
}

/* R rows of N samples in one plane, as compensate/compiled.py lays them out; B: axes beside the
   plane. Results: how many pieces a row has, -1: it is left to fit.py; and of each piece (R, most)
   its first and last sample and the ticks (2) from its begin to its centre. */
typedef struct {
    whole rows, samples, beside, most;
    const double *t, *unit, *place, *radial, *smooth, *across, *turn, *command;  /* (..., N) */
    const whole *axes;                                                           /* (2 + B) */
    const whole *first, *last, *begin, *end, *zero, *step, *base, *grid;         /* (..., R) */
    const double *t0, *t1, *centre, *radius, *grown, *sweep, *limit, *plane, *own;
    double mismatch, smallest, flat, followed;
    whole *count, *low, *high, *found;
} Work;

/* Samples low to high, from t[0] to t[1], and the ticks commanded at both ends. */
typedef struct { whole low, high, tick[2][AXES]; double t[2]; } Run;

/* Whether an arc will do, or fit.py is to say it; the ticks from begin to centre; and the farthest
   place as a share of the limit. */
typedef struct { whole good, left, centre[2]; double excess; } Proof;

static void end_at(const Work *w, whole r, Run *run, int end, whole at)
{
    *(end ? &run->high : &run->low) = at;
    run->t[end] = w->t[at];
    for (whole k = 0; k < 2 + w->beside; k++) {
        const whole a = w->axes[k], own = a * w->rows + r, zero = w->zero[own], step = w->step[own];
        const double exact = w->command[a * w->samples + at] * TICKS;
        run->tick[end][k] = zero + (whole)rint((exact - (double)zero) / (double)step) * step;
    }
}

/* samples.beyond, of one interval */
static double hump(double step, double turn)
{
    const double over = larger(turn - fabs(step), 0.0);
    return over * over / (turn * 4.0 + NOTHING);
}

/* The largest of n values, between samples too; adds their squares. */
static double largest(whole n, const double *value, const double *over, double *sum)
{
    double most = 0.0;
    for (whole i = 0; i < n; i++) {
        const double size = fabs(value[i]) + larger(over[i], over[i + 1]);
        most = larger(most, size);
        sum[i] += size * size;
    }
    return most;
}

/* Proof._near: the square of the farthest place from an arc about c; good: whether plane and other
   axes keep to their own shares, asked where lost motion is followed. */
static double farthest(const Work *w, whole r, const Run *run, const double *c, double radius,
                       double growth, whole *good)
{
    double share[LONGEST], off[LONGEST], bend[LONGEST], sum[LONGEST], over[LONGEST], all = 0.0;
    const whole N = w->samples, l = run->low, h = run->high, n = h - l + 1;
    const whole a = l > w->first[r] ? l - 1 : l, m = (h < w->last[r] ? h + 1 : h) - a + 1;
    const double per = 1.0 / (run->t[1] - run->t[0]);
    for (whole i = 0; i < m; i++) {
        const double x = w->place[a + i] - c[0], y = w->place[N + a + i] - c[1];
        share[i] = (w->t[a + i] - run->t[0]) * per;
        off[i] = sqrt(x * x + y * y) - (growth * share[i] + radius);
    }
    bend[0] = bend[m - 1] = 0.0;
    for (whole i = 1; i < m - 1; i++)
        bend[i] = fabs((off[i + 1] - off[i]) - (off[i] - off[i - 1])) * w->smooth[a + i];
    const double *bent = bend + (l - a), *part = share + (l - a);
    double *v = off + (l - a);
    over[0] = over[n] = 0.0;
    for (whole i = 0; i < n - 1; i++)
        over[i + 1] = hump(v[i + 1] - v[i], larger(bent[i], bent[i + 1]));
    for (whole i = 0; i < n; i++) sum[i] = 0.0;
    const double plane = largest(n, v, over, sum);
    *good &= !w->followed || plane <= w->plane[r];
    for (whole k = 0; k < w->beside; k++) {
        const double *command = w->across + k * N + l, *turn = w->turn + k * N + l;
        const double from = (double)run->tick[0][2 + k] / TICKS;
        const double back = from - (double)run->tick[1][2 + k] / TICKS;
        for (whole i = 0; i < n; i++) v[i] = back * part[i] + command[i] - from;
        for (whole i = 0; i < n - 1; i++) over[i + 1] = hump(v[i + 1] - v[i], turn[i]);
        const double own = largest(n, v, over, sum);
        *good &= !w->followed || own <= w->own[k * w->rows + r];
    }
    for (whole i = 0; i < n; i++) all = larger(all, sum[i]);
    return all;
}

/* prove._multiple */
static double multiple(const double *value, const double *part, const double *weighed)
{
    double size = 0.0, both = 0.0;
    for (int k = 0; k < FITTED; k++) {
        size += part[k] * weighed[k];
        both += value[k] * weighed[k];
    }
    return both / (size > 0 ? size : 1.0);
}

/* Proof._fitted and _rounded: the centre as it will be written, mm from the nominal one, of a run
   that does not end where it begins. */
static void fit(const Work *w, whole r, const Run *run, const double place[2][2], double *drawn)
{
    const whole R = w->rows, N = w->samples;
    const double *unit[2] = {w->unit + run->low, w->unit + run->high};
    double ends[2], left[FITTED], g[FITTED], weighed[FITTED];
    for (int e = 0; e < 2; e++)
        ends[e] = unit[e][0] * place[e][0] + unit[e][N] * place[e][1] - w->radius[r]
                - w->grown[r] * run->t[e];
    const double x = unit[1][0] - unit[0][0], y = unit[1][N] - unit[0][N];
    const double length = sqrt(x * x + y * y);
    const double along[2] = {x / length, y / length}, across[2] = {-along[1], along[0]};
    const double move = (ends[1] - ends[0]) / length, moved[2] = {along[0] * move, along[1] * move};
    for (int k = 0; k < FITTED; k++) {
        const whole at = run->low + ((run->high - run->low) * fitted[k] >> 4);
        const double way[2] = {w->unit[at] - unit[0][0], w->unit[N + at] - unit[0][N]};
        g[k] = across[0] * way[0] + across[1] * way[1];
        left[k] = w->radial[at] - ends[0] - (moved[0] * way[0] + moved[1] * way[1]);
    }
    double off = multiple(left, g, g);
    for (int k = 0; k < FITTED; k++) weighed[k] = g[k] * (fabs(left[k] - off * g[k]) + EXACT);
    off = multiple(left, g, weighed);
    for (int k = 0; k < 2; k++) {
        const double grid = (double)w->grid[k * R + r];
        const double base = run->t[0] == 0 ? (double)w->base[k * R + r] : 0.0;
        const double way = (moved[k] + across[k] * off - place[0][k]) * TICKS - base;
        drawn[k] = place[0][k] + (base + rint(way / grid) * grid) / TICKS;
    }
}

/* Proof.run, for arcs that have one candidate. */
static Proof proven(const Work *w, whole r, const Run *run)
{
    const whole R = w->rows;
    double place[2][2], drawn[2], away[2][2], radius[2];
    Proof p = {.good = 1};
    for (int e = 0; e < 2; e++)
        for (int k = 0; k < 2; k++)
            place[e][k] = (double)run->tick[e][k] / TICKS - w->centre[k * R + r];
    fit(w, r, run, place, drawn);
    for (int e = 0; e < 2; e++) {
        for (int k = 0; k < 2; k++) away[e][k] = place[e][k] - drawn[k];
        radius[e] = sqrt(away[e][0] * away[e][0] + away[e][1] * away[e][1]);
    }
    const double part = run->t[1] - run->t[0], sweep = w->sweep[r] * part, size = fabs(sweep);
    const double cross = away[0][0] * away[1][1] - away[0][1] * away[1][0];
    double turned = atan2(sweep > 0 ? cross : -cross,
                          away[0][0] * away[1][0] + away[0][1] * away[1][1]);
    if (turned < 0) turned += TURN;
    const double missed = fabs(turned - size), most = smaller(0.5 * size, TURN / 2);
    p.good &= missed < most; /* only compared: the last bit of an angle may not be numpy's */
    p.good &= size / TURN >= SAME_ANGLE;
    p.good &= smaller(radius[0], radius[1]) > w->smallest;
    const double was = fabs(w->grown[r]) * part;
    p.good &= fabs(radius[1] - radius[0]) <= (was <= w->mismatch ? was + w->mismatch : was);
    const double all = farthest(w, r, run, drawn, radius[0], radius[1] - radius[0], &p.good);
    p.excess = sqrt(all) / larger(w->limit[r], EXACT);
    p.good &= p.excess <= 1.0;
    /* of what will not do it may lie beyond all ticks */
    for (int k = 0; k < 2 && p.good; k++)
        p.centre[k] = (whole)rint((drawn[k] - place[0][k]) * TICKS);
    /* Flat ones have one candidate more, or become chords: more of them, by r s^2 / 8. */
    const double coarse = larger((double)w->grid[r], (double)w->grid[R + r]) / TICKS;
    const double bow = w->radius[r] * sweep * sweep / 8;
    p.left = !p.good && bow < 2.5 * larger(FLAT * coarse, w->flat);
    return p;
}

/* Samples.until */
static whole until(const Work *w, whole low, whole high, double t)
{
    while (low < high) {
        const whole middle = (low + high) / 2;
        if (w->t[middle] < t) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* A piece more; how many there are. */
static whole put(const Work *w, whole r, whole n, const Run *run, const Proof *p)
{
    const whole at = r * w->most + n;
    w->low[at] = run->low;
    w->high[at] = run->high;
    for (int k = 0; k < 2; k++) w->found[2 * at + k] = p->centre[k];
    return n + 1;
}

/* Cutting._longest: the longest first run that will do, from one that is known to do (best, of
   proof p) or none; 0 where fit.py is to say it. */
static int longest(const Work *w, whole r, const Run *all, Run *best, Proof *p)
{
    whole reach = p->good ? best->high : all->low, over = p->good ? all->high : best->high;
    double excess = p->good ? 0.0 : p->excess;
    while (over - reach > ((reach - all->low) / NEARLY > 1 ? (reach - all->low) / NEARLY : 1)) {
        const double begin = w->t[all->low];
        const double far = begin + (w->t[over] - begin) / sqrt(larger(excess, 1.0));
        whole middle = (reach + over) / 2;
        if (excess > 1.0) middle = until(w, all->low, over, nextafter(far, 2.0)) - 1;
        if (middle < reach + 1) middle = reach + 1;
        Run run = *all;
        end_at(w, r, &run, 1, middle);
        const Proof tried = proven(w, r, &run);
        if (tried.left) return 0;
        if (tried.good) { reach = middle; *best = run; *p = tried; excess = 0.0; }
        else { over = middle; excess = tried.excess; }
    }
    return reach > all->low;
}

/* Cutting.run: how many pieces row r has. */
static whole pieces(const Work *w, whole r)
{
    Run run = {.low = w->first[r], .high = w->last[r], .t = {w->t0[r], w->t1[r]}};
    whole n = 0;
    if (run.high - run.low >= LONGEST - 1) return -1;
    if (fabs(w->sweep[r] * (run.t[1] - run.t[0])) > WIDEST) return -1;
    for (whole k = 0; k < 2 + w->beside; k++) {
        run.tick[0][k] = w->begin[w->axes[k] * w->rows + r];
        run.tick[1][k] = w->end[w->axes[k] * w->rows + r];
    }
    Proof whole_run = proven(w, r, &run);
    while (!whole_run.left && !whole_run.good) {
        if (run.low + 1 == run.high || n + 2 > w->most) return -1;
        Run one = run, two = run;
        const whole half = (run.low + run.high) / 2;
        end_at(w, r, &one, 1, half);
        Proof p = proven(w, r, &one);
        if (p.left) return -1;
        if (p.good) {
            end_at(w, r, &two, 0, half);
            const Proof rest = proven(w, r, &two);
            if (rest.left) return -1;
            if (rest.good) return put(w, r, put(w, r, n, &one, &p), &two, &rest);
        }
        if (!longest(w, r, &run, &one, &p)) return -1;
        n = put(w, r, n, &one, &p);
        end_at(w, r, &run, 0, one.high);
        whole_run = proven(w, r, &run);
    }
    return whole_run.left ? -1 : put(w, r, n, &run, &whole_run);
}

void settle(const Work *w)
{
    for (whole r = 0; r < w->rows; r++) w->count[r] = pieces(w, r);
}
