/* A self-organising fuzzy network by hand: bilinear table, target as stored, Kalman filter on the four rules that
   fired, leak. The loop is that of our probes: a point that moves by a fixed stride, the network, a sum. */
#include <math.h>
#include <string.h>

#define SETS 7
#define RULES 49
#define ROOM 64

typedef struct {
    double k_e, k_ec, k_d, keep, most, kg, r, q, cap, leak, clamp, reach;
    double table[169], prior[RULES]; /* rows: EC */
    long delay;
} Network;

typedef struct {
    double error, rate, offset, w[RULES], p[RULES][RULES], e[ROOM], ec[ROOM], d[ROOM];
    long known, at;
} State;

typedef struct {
    int k;
    double h[4];
} Fired;

static inline double held(double x, double most) { return x > most ? most : x < -most ? -most : x; }

static inline Fired fired(double e, double ec)
{
    double x = held(e, 6.0) + 6.0, y = held(ec, 6.0) + 6.0;
    int i = (int)(0.5 * x), j = (int)(0.5 * y);
    i = i > SETS - 2 ? SETS - 2 : i;
    j = j > SETS - 2 ? SETS - 2 : j;
    double mu = 0.5 * x - i, nu = 0.5 * y - j;
    Fired f = {SETS * j + i, {(1.0 - nu) * (1.0 - mu), (1.0 - nu) * mu, nu * (1.0 - mu), nu * mu}};
    return f;
}

static inline double said(const double *w, Fired f)
{
    return f.h[0] * w[f.k] + f.h[1] * w[f.k + 1] + f.h[2] * w[f.k + 7] + f.h[3] * w[f.k + 8];
}

static inline double measure(const double *t, double e, double ec)
{
    double x = held(e, 6.0) + 6.0, y = held(ec, 6.0) + 6.0;
    int j = x >= 12.0 ? 11 : (int)x, i = y >= 12.0 ? 11 : (int)y;
    const double *c = t + 13 * i + j;
    x -= j;
    y -= i;
    return (1.0 - y) * ((1.0 - x) * c[0] + x * c[1]) + y * ((1.0 - x) * c[13] + x * c[14]);
}

static inline void learn(const Network *n, State *s, Fired f, double innovation)
{
    double gain[RULES], scale[RULES], v = n->r;
    const double *a = s->p[f.k], *b = s->p[f.k + 1], *c = s->p[f.k + 7], *d = s->p[f.k + 8];
    for (int i = 0; i < RULES; i++)
        gain[i] = f.h[0] * a[i] + f.h[1] * b[i] + f.h[2] * c[i] + f.h[3] * d[i];
    v += said(gain, f);
    double step = innovation / v, root = 1.0 / sqrt(v);
    for (int i = 0; i < RULES; i++) {
        s->w[i] = held(s->w[i] + gain[i] * step, n->clamp);
        double g = gain[i] * root, after = s->p[i][i] - g * g + n->q;
        scale[i] = after > n->cap ? sqrt(n->cap / after) : 1.0;
        gain[i] = g * scale[i];
        s->p[i][i] += n->q;
    }
    for (int i = 0; i < RULES; i++)
        for (int j = 0; j < RULES; j++)
            s->p[i][j] = s->p[i][j] * (scale[i] * scale[j]) - gain[i] * gain[j];
}

static inline double step(const Network *n, State *s, double seen)
{
    s->rate = n->keep * s->rate + (1.0 - n->keep) * (s->known ? seen - s->error : 0.0);
    s->error = seen;
    s->known += s->known < ROOM;
    double e = n->k_e * seen, ec = n->k_ec * s->rate, g = n->kg * measure(n->table, e, ec);
    int pushed = fabs(s->offset) >= 0.99 * n->most && g * s->offset > 0.0;
    if (s->known > n->delay && !pushed) {
        long then = (s->at - n->delay) & (ROOM - 1);
        Fired past = fired(s->e[then], s->ec[then]);
        learn(n, s, past, s->d[then] + g - said(s->w, past));
        for (int i = 0; i < RULES; i++)
            s->w[i] += n->leak * (n->prior[i] - s->w[i]);
    }
    double level = held(said(s->w, fired(e, ec)), 6.0);
    s->e[s->at] = e;
    s->ec[s->at] = ec;
    s->d[s->at] = level;
    s->at = (s->at + 1) & (ROOM - 1);
    return s->offset = held(n->k_d * level, n->most);
}

double sofnn_learn(const Network *n, long points)
{
    State s;
    double x = 0.0, sum = 0.0;
    memset(&s, 0, sizeof s);
    memcpy(s.w, n->prior, sizeof s.w);
    for (int i = 0; i < RULES; i++)
        s.p[i][i] = 1.0;
    for (long k = 0; k < points; k++) {
        x += 0.7548776662466927;
        x = x > 1.0 ? x - 2.0 : x;
        sum += step(n, &s, n->reach * x);
    }
    return sum;
}
