/* ours.pd at the machine. See pd_machine.h.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#include "pd_machine.h"

#include <float.h>
#include <stddef.h>

static int pd_finite(double x)
{
    return x >= -DBL_MAX && x <= DBL_MAX;
}

static double pd_size(double x)
{
    return x < 0 ? -x : x;
}

void pd_machine_init(pd_machine *m)
{
    static const pd_machine nothing;

    *m = nothing;
    pd_defaults(&m->params);
    pd_start(&m->params, &m->state);
    m->max_output = 1.0;
    m->max_error = 100.0;
    m->max_wrong_way = 2.5;
}

/* Holds the outputs at zero until enable has been taken away. */
static void pd_stop(pd_machine *m, pd_fault why)
{
    m->fault = why;
    m->enabled = 0;
    m->saturated = 0;
    m->moving = 0;
    m->output = 0;
}

/* An output with the machine's sign, inside max_output. */
static double pd_held(pd_machine *m, double output)
{
    const double turned = -output;

    if (m->max_output > 0 && pd_size(turned) >= m->max_output) {
        m->saturated = 1;
        return turned > 0 ? m->max_output : -m->max_output;
    }
    return turned;
}

void pd_machine_step(pd_machine *m, int enable, int index_enable, double command, double feedback)
{
    const int indexed = m->index_enable && !index_enable;
    double move;
    double raw_output;

    m->index_enable = index_enable;
    m->error = command - feedback;
    if (!enable) {
        pd_stop(m, PD_RUNS);
        return;
    }
    if (m->fault != PD_RUNS) {
        return;
    }
    if (!pd_finite(command) || !pd_finite(feedback)) {
        pd_stop(m, PD_NOT_FINITE);
        return;
    }
    if (m->max_error > 0 && pd_size(m->error) > m->max_error) {
        pd_stop(m, PD_FOLLOWING_ERROR);
        return;
    }
    if (!m->enabled) {
        pd_start(&m->params, &m->state);
        m->enabled = 1;
        m->moving = 0;
        m->offset = 0;
        m->wrong_way = 0;
    }
    if (indexed && m->moving) {
        m->offset = (m->last_feedback + m->last_move) - feedback;
    }
    if (m->offset != 0) {
        command += m->offset;
        feedback += m->offset;
    }

    /* Does the axis move against an output that should close the error, and no slower than before? */
    move = m->moving ? feedback - m->last_feedback : 0;
    if (move != 0) {
        const int closing = m->output != 0 && (m->output > 0) == (m->error > 0);

        if (!closing || (move > 0) == (m->error > 0)) {
            m->wrong_way = 0;
        } else if (pd_size(move) >= pd_size(m->last_move)) {
            m->wrong_way += pd_size(move);
        }
    }
    m->last_move = move;
    m->last_feedback = feedback;
    if (m->max_wrong_way > 0 && m->wrong_way > m->max_wrong_way) {
        pd_stop(m, PD_WRONG_WAY);
        return;
    }

    raw_output = pd_step(&m->params, &m->state, command, feedback);
    if (!pd_finite(raw_output)) {
        pd_stop(m, PD_NOT_FINITE);
        return;
    }
    m->saturated = 0;
    m->output = pd_held(m, raw_output);
    m->moving = 1;
}
