/* 49 rules by hand: seven triangles on each input at even centres, consequent of rule i, j at clip(i + j - 3, 0, 6).
   The loop is that of our probes: a point that moves by a fixed stride, the system, a sum. -ffp-contract=off. */
#include <math.h>
#include <string.h>

#define SETS 7
#define CELLS 100

typedef struct {
    double centres[SETS], over[SETS - 1], table[SETS * SETS]; /* active rules */
    double low, high, width;                                  /* universe of the output, distance of its peaks */
    int consequent[SETS * SETS];
    double nodes[CELLS], sets[SETS][CELLS];
} Fuzzy;

static inline double clipped(double x, double low, double high) { return x > high ? high : x > low ? x : low; }

static inline int interval(const double *c, double x)
{
    int i = 0;
    for (int k = 1; k < SETS - 1; k++)
        i += x >= c[k];
    return i;
}

static inline double none(const Fuzzy *p, double x, double y) { (void)p; return x + y; }

/* product, weighted average: of 49 rules the four around the point fire */
static inline double active(const Fuzzy *p, double x, double y)
{
    const double *c = p->centres;
    x = clipped(x, c[0], c[SETS - 1]);
    y = clipped(y, c[0], c[SETS - 1]);
    int i = interval(c, x), j = interval(c, y);
    double mu = (x - c[i]) * p->over[i], nu = (y - c[j]) * p->over[j];
    const double *t = p->table + SETS * i + j;
    double lower = (1.0 - nu) * t[0] + nu * t[1], upper = (1.0 - nu) * t[SETS] + nu * t[SETS + 1];
    return (1.0 - mu) * lower + mu * upper;
}

static inline void memberships(const Fuzzy *p, double x, double *m)
{
    for (int i = 0; i < SETS; i++)
        m[i] = clipped(1.0 - fabs(x - p->centres[i]) * p->over[0], 0.0, 1.0);
}

/* product, weighted average: all 49 rules */
static inline double dense(const Fuzzy *p, double x, double y)
{
    double m[SETS], n[SETS], above = 0.0, below = 0.0;
    memberships(p, x, m);
    memberships(p, y, n);
    for (int i = 0; i < SETS; i++)
        for (int j = 0; j < SETS; j++) {
            double w = m[i] * n[j];
            above += w * p->table[SETS * i + j];
            below += w;
        }
    return above / below;
}

static inline void degrees(const Fuzzy *p, double x, double y, double *g)
{
    double m[SETS], n[SETS];
    memberships(p, x, m);
    memberships(p, y, n);
    memset(g, 0, SETS * sizeof *g);
    for (int i = 0; i < SETS; i++)
        for (int j = 0; j < SETS; j++) {
            double w = m[i] < n[j] ? m[i] : n[j];
            int k = p->consequent[SETS * i + j];
            g[k] = w > g[k] ? w : g[k];
        }
}

/* minimum, maximum, centroid by 100 midpoints */
static inline double sampled(const Fuzzy *p, double x, double y)
{
    double g[SETS], mu[CELLS] = {0.0}, area = 0.0, moment = 0.0;
    degrees(p, x, y, g);
    for (int k = 0; k < SETS; k++)
        if (g[k] > 0.0)
            for (int c = 0; c < CELLS; c++) {
                double v = g[k] < p->sets[k][c] ? g[k] : p->sets[k][c];
                mu[c] = v > mu[c] ? v : mu[c];
            }
    for (int c = 0; c < CELLS; c++) {
        area += mu[c];
        moment += mu[c] * p->nodes[c];
    }
    return moment / area;
}

/* the same centroid in closed form: each set's two sides, less what two neighbours share */
static inline double exact(const Fuzzy *p, double x, double y)
{
    double g[SETS], area = 0.0, moment = 0.0, w = p->width;
    degrees(p, x, y, g);
    for (int k = 0; k < SETS; k++) {
        double part = w * (2.0 * g[k] - g[k] * g[k]);
        area += part;
        moment += part * p->centres[k];
    }
    for (int k = 0; k < SETS - 1; k++) {
        double low = g[k] < g[k + 1] ? g[k] : g[k + 1], m = low < 0.5 ? low : 0.5, part = w * m * (1.0 - m);
        area -= part;
        moment -= part * 0.5 * (p->centres[k] + p->centres[k + 1]);
    }
    return moment / area;
}

#define LOOP(name)                                                                                                     \
    double fuzzy_##name(const Fuzzy *p, long points)                                                                   \
    {                                                                                                                  \
        double x = 0.0, y = 0.0, sum = 0.0;                                                                            \
        for (long k = 0; k < points; k++) {                                                                            \
            x += 0.7548776662466927;                                                                                   \
            y += 0.5698402909980532;                                                                                   \
            x = x > 1.0 ? x - 2.0 : x;                                                                                 \
            y = y > 1.0 ? y - 2.0 : y;                                                                                 \
            sum += name(p, x, y);                                                                                      \
        }                                                                                                              \
        return sum;                                                                                                    \
    }

LOOP(none)
LOOP(active)
LOOP(dense)
LOOP(sampled)
LOOP(exact)
