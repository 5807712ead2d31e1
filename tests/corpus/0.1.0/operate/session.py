"""vud_lathe corrected.vud_beta_e sequence: what was done to the running machine, done again.

Written by Leadscrew 0.1.0. Run it with `python session.py`: it prints "identical" and ends with code 0 if all signals
are the same bits as in that run, else it says where they part first and ends with code 1.
"""

import sys

from leadscrew.operate import Event, Operated, Start

# one control period is 0.001 s; a period in an event is the number of periods that were done when it took effect
start = Start(
    study='vud_lathe',
    controller='corrected.vud_beta_e',
    scenario='sequence',
    seed=4,
)
events = [
    # t = 0.06 s
    Event(period=60, do='set', changes={'controller.tau': 0.8}, over=100, how='ramped', mark='b79b2bf85e20bd93'),
    # t = 0.1 s
    Event(period=100, do='switch', controller='ours.pd', how='not bumpless', mark='79b01817802a06b1'),
]
periods = 200
digest = "395fcb9cd08bbb823a8dc71915a00b9672c7938e9bc363f417a1ce015e60c1ff"

machine = Operated(start)
for event in events:
    # advance() would give the rows of all signals; advance_to() only runs on
    machine.advance_to(event.period)
    if machine.digest[:16] != event.mark:
        sys.exit(f"not identical: the signals part before t = {event.period * machine.period_s:g} s; next: {event}")
    machine.apply(event)  # as by hand: machine.set(...), machine.switch(...), with the ramp of that run
machine.advance_to(periods)

if machine.digest != digest:
    sys.exit(f"not identical: the signals part after the last event; digest {machine.digest}, expected {digest}")
print(f"identical: {machine.period} periods of {len(machine.columns)} signals, bit for bit")
