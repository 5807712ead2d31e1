"""The study ``grey_turning``: constant cutting force in turning with a grey-prediction fuzzy controller."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.grey_turning.controllers import CONTROLLERS
from leadscrew.studies.grey_turning.scenarios import SCENARIOS, build
from leadscrew.studies.results import contents_of
from leadscrew.study_data import Assumption, Study

ASSUMED = (
    Assumption(
        "scaling factors S6 and S9",
        "4.2 N, 1.35 N, 3.07 mV and 28 N, 15.4 N, 21.4 mV",
        "The paper prints none. S6 is fitted to the overshoots and the rise time of 5.1, S9 together with the servo to "
        "the four numbers of 5.2; one set that gives both sections was not found. S9/2 is S9 at half the gain; STFC "
        "and SBN "
        "are tuned by us for plants F and N.",
    ),
    Assumption(
        "feed servo (plant F)",
        "150 mm/min a volt, 40 rad/s, damping 0.7, no dead time",
        "The paper names no servo. 150 mm/min at 1 V are the ends of the axes of Figure 6; the rate comes out of a fit "
        "to 5.2, which does not identify it: 48 rad/s with 6 ms of dead time and 66 rad/s with 9 ms, each with factors "
        "of its own, meet the four numbers to 3 %. Plant N, 20 rad/s with 20 ms of dead time, can be fitted to 5.1.",
    ),
    Assumption(
        "rules (Table 1)",
        "consequent clip(i + j, −3, 3)",
        "Table 1 is missing in the text that we have. This is the diagonal table that is usual since MacVicar-Whelan.",
    ),
    Assumption(
        "sampling period", "20 ms", "Not given. It keeps the runout of 20 Hz below half the sampling frequency."
    ),
    Assumption(
        "predicted change of the error",
        "reading B: predicted error less the one predicted before",
        "The text allows reading A too, predicted less measured error; with S6 it ends in a limit cycle.",
    ),
    Assumption(
        "prediction held to 0 ... 300 N",
        "0 to twice the set-point",
        "Windows that begin in air predict nonsense; in the cut the bounds are not reached.",
    ),
    Assumption(
        "material",
        "S45C",
        "Not named. In iron the largest feed makes too little force at 1 mm for an overshoot of 48.6 %.",
    ),
    Assumption(
        "feed f of (1)",
        "per revolution",
        "The text says feedrate; put in as mm/min, (1) gives a force of another order than the 150 N of the figures.",
    ),
    Assumption(
        "noise and runout", "2 N a reading, 0.01 mm", "Not given; Figure 5 shows more, and is drawn here with 8 N."
    ),
    Assumption(
        "compliance",
        "20 kN/mm, force along the feed equal to the main force",
        "Not given. With half the main force along the feed, which is usual, the overshoots of S9 are smaller: see the "
        "unknown numbers of the machine.",
    ),
    Assumption(
        "window of the steady errors of 5.2",
        "1.5 to 2 s",
        "Not given. It is the half second before the depth changes, and S9 is fitted to it.",
    ),
    Assumption(
        "depth axis", "0.25 s from 10 to 90 %", "Not given: the depth loop of the whole lathe, with factors of our own."
    ),
    Assumption(
        "rough rules of Figure 11",
        "the change of the error counts a third, with S9",
        "The paper names none. The strongest contrast of 30 pairs of rules and factors that were tried.",
    ),
    Assumption(
        "cost that predictors are tuned for",
        "mean ITAE of true and filtered force over 2 s, 0.5 N·s² for each percent of overshoot above 1 %",
        "Ours. Under three other costs the gain of grey prediction differs: see the predictors at equal effort.",
    ),
    Assumption(
        "random plants",
        "Kf ± 40 % in its logarithm, P 0.65 to 0.96, 0.5 to 1.5 mm, 0.5 to 5 N of noise, servos of 25 to 60 rad/s",
        "Ours; a draw counts where its feed for 150 N lies between 15 and 130 mm/min.",
    ),
    Assumption(
        "what an engineer would tune for",
        "mean of the integrals of the true error at an entry and a falling depth, 1 N·s for each percent above 10 %",
        "Ours, with the lathes: Kf 1600 to 3200 N, P 0.7 to 0.85, 25 to 60 rad/s, up to 20 ms of dead time, 10 to 40 "
        "kN/mm, noise of 0.5 to 5 N. The depth is not drawn: it changes in the programme.",
    ),
    Assumption(
        "spindle and depth loops",
        "60 1/min, 20 1/min, 0.12 V; 0.05 mm, 0.02 mm, 0.15 V",
        "The paper shows no run of them. First-order spindle of 0.3 s, radial axis of 5 mm/s a volt.",
    ),
)

STUDY = Study(
    name="grey_turning",
    title="Constant cutting force in turning with a grey-prediction fuzzy controller",
    paper=(
        "Grey-prediction fuzzy control of constant turning force on a retrofitted old lathe (OLRTS). The text that we "
        "have names no authors; equations (2) to (8), Table 1 and the figures are missing in it."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    folder=Path(__file__).parent,
    contents=contents_of(*(f"leadscrew.studies.grey_turning.{part}" for part in ("claims", "experiments", "figures"))),
    summary=(
        "A grey model of five samples predicts the force for a fuzzy controller. Near the set-point the model is a "
        "fixed filter and the controller a PI: prediction rescues factors that are badly scaled, and hardly a well "
        "tuned loop. Tuned alike, a PID or a Smith predictor is better; so is what learns (1) from encoders."
    ),
    record=("sensor",),
    card=("overshoot_falling.tfc", "overshoot_falling.gpfc", "rise_fixed.gpfc"),
    assumed=ASSUMED,
    method=(
        "The chip is the room between the edge and the surface that it left one revolution before; tool and work give "
        "way. The drives are stepped exactly, the chip every millisecond; the controller acts every 20 ms on the "
        "filtered force. "
        "Numbers with noise are means over 4 to 60 noise seeds, the same for both controllers.",
        "Printed columns follow the paper's equations to the letter. Corrected columns have the paper's laws with our "
        "factors, rules and lathe, since it prints none of them; what these were fitted to is called fitted. Ours: "
        "controllers tuned by us.",
        "Overshoot is that of the filtered force, as the paper has it, rise time is from 10 to 90 % and in whole "
        "samples, the steady error is the mean of its size over the last second.",
    ),
    limits=(
        "All results are for a simulated lathe. Nothing here is evidence about the authors' machine.",
        "Meeting a number that something was fitted to proves nothing. The random plants, the comparison at equal "
        "effort and the equations are fitted to nothing.",
        "One search of 300 evaluations does not find the last percent of a controller: with gains found by another "
        "program a Smith predictor costs as little as the PI with depth feed-forward; the GPFC gains nothing.",
        "Chatter, tool wear and heat are not in the plant; the force law is for one steel, between feeds of 0.02 and "
        "0.1 "
        "mm a revolution, which published tables hardly reach.",
        "The filtered force hides what the tool feels: with the factors of Figure 9 the true force overshoots by far "
        "more.",
    ),
)
