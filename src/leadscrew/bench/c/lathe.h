/* The lathe servo under the VUD controller with 36 rules, as one would write it by hand. */
#ifndef LATHE_H
#define LATHE_H

typedef struct {
    double target, resolution;                                         /* reference, grating */
    double error_scale, rate_scale, rate_interval, tau, floor;         /* controller */
    double output_tau, output_gain;
    double centres[6], reciprocal_widths[5], rules[36];
    double full_duty_speed;
    double a[14], b[5];                                                /* exact zero-order hold, lower triangle */
    double pwm_lag, electrical_lag, mechanical_lag, grating_lag;       /* the same plant as a derivative */
    double period, substeps, bound;
} Lathe;

typedef struct {
    double pwm, current, speed, position, reading;
} Axis;

typedef struct {
    double e, started, rho;
    Axis axis;
    double squares, absolutes, time, largest;
} Motion;

#endif
