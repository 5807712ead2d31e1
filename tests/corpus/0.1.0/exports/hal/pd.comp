/* ours.pd as a LinuxCNC HAL component, in place of pid.
 *
 * SPDX-License-Identifier: GPL-2.0-or-later
 *
 * This wrapper includes LinuxCNC's headers, which are under the GPL: the wrapper, and the module that halcompile builds
 * from it, are free software under the GNU General Public License, version 2 or (at your option) any later version,
 * WITHOUT ANY WARRANTY. The controller in pd.c and pd_machine.c stays under its own terms.
 *
 * Install, from this folder: halcompile --install pd.comp
 */
component pd "ours.pd: The duty against the error and its filtered derivative.";

pin in float command "where the axis is to be, mm";
pin in float feedback "where the axis is, as measured, mm";
pin in bit enable "run; when false the outputs are zero, the controller is reset and faults are cleared";
pin in bit index_enable "connect to the encoder's index-enable: the jump of the coordinates at the index is not noticed";
pin in float maxoutput = 1.0 "largest size of an output; 0: none";
pin out float output "to the drive";
pin out float error "command - feedback, mm";
pin out bit saturated "an output is at maxoutput";
pin out bit fault "outputs are held at zero until enable has been taken away; see fault-code";
pin out s32 fault_code "0 runs, 1 not a finite number, 2 following error, 3 moved the wrong way, 4 period of the thread";
pin out bit bad_parameter "a parameter is out of its range: its last good value is in force";

param rw float max_following_error = 100.0 "fault where the size of error is above, mm; 0: no limit";
param rw float max_wrong_way = 2.5 "fault where the axis has moved so far against the output, mm; 0: no limit";
param rw float kp = 0.2505263157894737 "duty per millimetre of error, 1/mm, in [0, inf)";
param rw float t-d = 0.0154 "derivative time, s, in [0, inf)";
param r float period_design = 0.001 "period that the controller was designed for, s";
param r s32 every "a control step at every so many calls";

variable pd_hal inside;
function _ fp "a control step, at every so many calls as the parameter every says";

option extra_setup yes;
option no_convenience_defines yes;
include "pd_hal.h";
license "GPL";
;;
#define FUNCTION(name) static void name(struct __comp_state *inst, long period)

static int extra_setup(struct __comp_state *inst, char *prefix, long extra_arg)
{
    (void)extra_arg;
    pd_machine_init(&inst->inside.machine);
    rtapi_snprintf(inst->inside.name, sizeof(inst->inside.name), "%s", prefix);
    inst->inside.held_maxoutput = inst->inside.machine.max_output;
    inst->inside.held_max_following_error = inst->inside.machine.max_error;
    inst->inside.held_max_wrong_way = inst->inside.machine.max_wrong_way;
    inst->inside.held_kp = inst->inside.machine.params.kp;
    inst->inside.held_t_d = inst->inside.machine.params.t_d;
    return 0;
}

/* Finds how many calls make a control period, and whether they make it within 1 %. */
static void plan(struct __comp_state *inst, long period)
{
    const double design = 0.001;
    const double calls = design / (period * 1e-9);
    double actual, off;

    inst->every = calls < 1.5 ? 1 : (hal_s32_t)(calls + 0.5);
    actual = inst->every * (period * 1e-9);
    off = actual > design ? actual - design : design - actual;
    inst->inside.usable = off <= 0.01 * design;
    inst->inside.period = period;
    inst->inside.wait = 0;
    if (!inst->inside.usable) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: designed for a period of %ld ns, but the thread calls it every %ld ns; it will not run\n",
                        inst->inside.name, 1000000L, period);
    }
}

/* Says once that a value is out of its range. */
static void refuse(struct __comp_state *inst, const char *what, const char *range)
{
    if (!inst->inside.bad_reported) {
        inst->inside.bad_reported = 1;
        rtapi_print_msg(RTAPI_MSG_ERR, "%s.%s must be a number in %s; its last good value stays in force\n",
                        inst->inside.name, what, range);
    }
}

/* Takes over the parameters that have changed and are in their ranges. */
static void take(struct __comp_state *inst)
{
    int bad = 0;

    {
        const double wanted = (double)*inst->maxoutput;

        if (!(wanted >= 0.0 && wanted <= DBL_MAX)) {
            bad = 1;
            refuse(inst, "maxoutput", "[0, inf)");
        } else if (wanted != inst->inside.held_maxoutput) {
            inst->inside.held_maxoutput = wanted;
            inst->inside.machine.max_output = wanted;
        }
    }
    {
        const double wanted = (double)inst->max_following_error;

        if (!(wanted >= 0.0 && wanted <= DBL_MAX)) {
            bad = 1;
            refuse(inst, "max-following-error", "[0, inf)");
        } else if (wanted != inst->inside.held_max_following_error) {
            inst->inside.held_max_following_error = wanted;
            inst->inside.machine.max_error = wanted;
        }
    }
    {
        const double wanted = (double)inst->max_wrong_way;

        if (!(wanted >= 0.0 && wanted <= DBL_MAX)) {
            bad = 1;
            refuse(inst, "max-wrong-way", "[0, inf)");
        } else if (wanted != inst->inside.held_max_wrong_way) {
            inst->inside.held_max_wrong_way = wanted;
            inst->inside.machine.max_wrong_way = wanted;
        }
    }
    {
        const double wanted = (double)inst->kp;

        if (!(wanted >= 0.0 && wanted <= DBL_MAX)) {
            bad = 1;
            refuse(inst, "kp", "[0, inf)");
        } else if (wanted != inst->inside.held_kp) {
            inst->inside.held_kp = wanted;
            inst->inside.machine.params.kp = wanted;
        }
    }
    {
        const double wanted = (double)inst->t_d;

        if (!(wanted >= 0.0 && wanted <= DBL_MAX)) {
            bad = 1;
            refuse(inst, "t-d", "[0, inf)");
        } else if (wanted != inst->inside.held_t_d) {
            inst->inside.held_t_d = wanted;
            inst->inside.machine.params.t_d = wanted;
        }
    }
    inst->inside.bad_reported = bad;
    *inst->bad_parameter = bad;
}

static void step(struct __comp_state *inst, int enable)
{
    pd_machine_step(&inst->inside.machine, enable, *inst->index_enable,
        (double)*inst->command,
        (double)*inst->feedback);
}

FUNCTION(_)
{
    const pd_machine *m = &inst->inside.machine;
    hal_s32_t code;

    if (period != inst->inside.period) {
        plan(inst, period);
    }
    take(inst);
    if (!*inst->enable || !inst->inside.usable) {
        inst->inside.wait = 0;
        step(inst, 0);
    } else if (inst->inside.wait > 0) {
        inst->inside.wait--;
        return;
    } else {
        inst->inside.wait = inst->every - 1;
        step(inst, 1);
    }
    code = inst->inside.usable ? (hal_s32_t)m->fault : 4;
    *inst->output = m->output;
    *inst->error = m->error;
    *inst->saturated = m->saturated;
    *inst->fault = code != 0;
    *inst->fault_code = code;
}
