/* The ball-screw stage under the benchmark's soft controller, by hand: five ways to step it through a hold.
   Equations: leadscrew/bench/stage.py. */
#include <complex.h>
#include <math.h>

typedef struct {
    double amplitude, rate, period, substeps;                               /* command in rad, hold, steps of a hold */
    double lam, gain, smooth, ahead_coulomb, ahead_viscous;                 /* controller */
    double inertia, stiffness, damping, viscous, coulomb, rise, per_speed; /* stage; rise = F_S - F_C, per_speed = 1/v_s */
} Stage;

typedef struct {
    double angle, speed, bristle;
} State;

static inline double level(const Stage *p, double v)
{
    double r = v * p->per_speed;
    return r * r > 40.0 ? p->coulomb : p->coulomb + p->rise * exp(-r * r);
}

static inline State rates(const Stage *p, State s, double torque)
{
    double z = s.speed - fabs(s.speed) * s.bristle * p->stiffness / level(p, s.speed);
    State f = { s.speed,
        (torque - p->stiffness * s.bristle - p->damping * z - p->viscous * s.speed) / p->inertia, z };
    return f;
}

static inline State along(State s, double h, State k)
{
    State x = { s.angle + h * k.angle, s.speed + h * k.speed, s.bristle + h * k.bristle };
    return x;
}

static inline State euler(const Stage *p, State s, double torque, double h)
{
    return along(s, h, rates(p, s, torque));
}

static inline State rk4(const Stage *p, State s, double torque, double h)
{
    State a = rates(p, s, torque), b = rates(p, along(s, 0.5 * h, a), torque);
    State c = rates(p, along(s, 0.5 * h, b), torque), d = rates(p, along(s, h, c), torque), sum;
    sum.angle = a.angle + 2.0 * b.angle + 2.0 * c.angle + d.angle;
    sum.speed = a.speed + 2.0 * b.speed + 2.0 * c.speed + d.speed;
    sum.bristle = a.bristle + 2.0 * b.bristle + 2.0 * c.bristle + d.bristle;
    return along(s, h / 6.0, sum);
}

/* the naive split: bristles exactly at the frozen speed, then the speed, its own damping implicit */
static inline State split(const Stage *p, State s, double torque, double h)
{
    double g = level(p, s.speed) / p->stiffness, rate = fabs(s.speed) / g;
    double steady = s.speed > 0.0 ? g : s.speed < 0.0 ? -g : 0.0;
    double z = s.speed != 0.0 ? steady + (s.bristle - steady) * exp(-rate * h) : s.bristle;
    double v = (p->inertia * s.speed + h * (torque - p->stiffness * z + p->damping * rate * z))
        / (p->inertia + h * (p->damping + p->viscous));
    State x = { s.angle + h * v, v, z };
    return x;
}

/* backward Euler with the bristles eliminated, Newton on the speed */
static inline State implicit(const Stage *p, State s, double torque, double h)
{
    double v = s.speed, z = s.bristle;
    for (int i = 0; i < 8; i++) {
        double r = v * p->per_speed, over = r * r > 40.0 ? 0.0 : p->rise * exp(-r * r), side = v >= 0.0 ? 1.0 : -1.0;
        double g = (p->coulomb + over) / p->stiffness, slope = -2.0 * r * p->per_speed * over / p->stiffness;
        double below = 1.0 + h * fabs(v) / g;
        z = (s.bristle + h * v) / below;
        double bend = (h - z * h * (side / g - fabs(v) * slope / (g * g))) / below;
        double left = p->inertia * (v - s.speed)
            - h * (torque - p->stiffness * z - p->viscous * v) + p->damping * (z - s.bristle);
        double step = left / (p->inertia + h * p->viscous + (h * p->stiffness + p->damping) * bend);
        v -= step;
        if (fabs(step) <= 1e-12 * fabs(v))
            break;
    }
    State x = { s.angle + h * v, v, z };
    return x;
}

/* exponential Rosenbrock-Euler: x + h phi_1(h A) f with the 2x2 Jacobian of speed and bristles, phi by divided differences */
static inline State exponential(const Stage *p, State s, double torque, double h)
{
    State f = rates(p, s, torque);
    double v = s.speed, z = s.bristle, g = level(p, v), side = v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
    double slope = -2.0 * v * p->per_speed * p->per_speed * (g - p->coulomb);
    double zv = 1.0 - p->stiffness * z / g * (side - fabs(v) * slope / g), zz = -fabs(v) * p->stiffness / g;
    double vv = -(p->damping * zv + p->viscous) / p->inertia, vz = -(p->stiffness + p->damping * zz) / p->inertia;
    double half = 0.5 * h * (vv + zz), det = h * h * (vv * zz - vz * zv), under = half * half - det;
    double phi1[2], phi2[2]; /* phi(h A) = phi[0] + phi[1] h A */
    if (under >= 0.0) {
        double root = sqrt(under), a = half < 0.0 ? half - root : half + root, b = a != 0.0 ? det / a : 0.0;
        double pa = fabs(a) > 1e-5 ? expm1(a) / a : 1.0 + 0.5 * a, pb = fabs(b) > 1e-5 ? expm1(b) / b : 1.0 + 0.5 * b;
        double qa = fabs(a) > 1e-4 ? (pa - 1.0) / a : 0.5 + a / 6.0, qb = fabs(b) > 1e-4 ? (pb - 1.0) / b : 0.5 + b / 6.0;
        double gap = fabs(a - b) > 1e-9 ? 1.0 / (a - b) : 0.0;
        phi1[1] = (pa - pb) * gap, phi1[0] = pa - phi1[1] * a;
        phi2[1] = (qa - qb) * gap, phi2[0] = qa - phi2[1] * a;
    } else {
        double complex a = half + I * sqrt(-under), pa = (cexp(a) - 1.0) / a, qa = (pa - 1.0) / a;
        phi1[1] = cimag(pa) / cimag(a), phi1[0] = creal(pa) - phi1[1] * half;
        phi2[1] = cimag(qa) / cimag(a), phi2[0] = creal(qa) - phi2[1] * half;
    }
    double av = h * (vv * f.speed + vz * f.bristle), az = h * (zv * f.speed + zz * f.bristle);
    State x = { s.angle + h * (v + h * (phi2[0] * f.speed + phi2[1] * av)),
        v + h * (phi1[0] * f.speed + phi1[1] * av), z + h * (phi1[0] * f.bristle + phi1[1] * az) };
    return x;
}

/* angles at the start of each hold; the state is left at the end */
#define LOOP(STEP)                                                                                                     \
    void stage_##STEP(const Stage *p, State *at, double *angles, long holds)                                           \
    {                                                                                                                  \
        State s = *at;                                                                                                 \
        double h = p->period / p->substeps;                                                                            \
        for (long k = 0; k < holds; k++) {                                                                             \
            double t = k * p->period, wave = p->rate * t;                                                              \
            double y = p->amplitude * sin(wave), v = p->amplitude * p->rate * cos(wave), a = -p->rate * p->rate * y;   \
            double ahead = p->ahead_coulomb * tanh(v / p->smooth) + p->ahead_viscous * v;                              \
            double torque = p->inertia * a + ahead - p->gain * (s.speed - v + p->lam * (s.angle - y));                 \
            angles[k] = s.angle;                                                                                       \
            for (int j = 0; j < (int)p->substeps; j++)                                                                 \
                s = STEP(p, s, torque, h);                                                                             \
        }                                                                                                              \
        *at = s;                                                                                                       \
    }

LOOP(euler)
LOOP(rk4)
LOOP(split)
LOOP(implicit)
LOOP(exponential)
