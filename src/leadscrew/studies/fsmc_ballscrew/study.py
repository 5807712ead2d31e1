"""The study ``fsmc_ballscrew``: three sliding-mode controllers of a ball-screw stage, judged by the double ball bar."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, build
from leadscrew.studies.results import contents_of
from leadscrew.study_data import Assumption, Study

ASSUMED = (
    Assumption(
        "speed of the friction estimate f̂",
        "the commanded speed (`friction_from = 'commanded'`)",
        "Our reading. The paper writes f̂ as a function of the state; with the parameters of Table 2 that is unstable, "
        "because σ̂₁ is twice σ₁. See the friction estimate.",
    ),
    Assumption(
        "surface of `corrected.smc`",
        "e' + λe in place of (8)",
        "Only without the integral does SMC keep an error at rest and err more than CSMC, as the text says.",
    ),
    Assumption(
        "rules of `corrected.fsmc`",
        "s_c turned round in all nine rules",
        "The printed ones act along s − s_c; the text builds them on CSMC, which acts along s + s_c.",
    ),
    Assumption(
        "scales of the fuzzy system, Figure 10",
        "S = 0.65 rad/s, S_c = 2.6 rad/s, U = 120 N·m",
        "The figure is lost. With S_c = S the corrected rules lose the stage; with less torque friction wins.",
    ),
    Assumption(
        "sets of Figures 8 and 9",
        "triangles with peaks at −1, 0, 1 and at −1, −0.5, 0, 0.5, 1",
        "The figures are lost; the text says triangular, Mamdani and centroid.",
    ),
    Assumption(
        "units of φ, η and u",
        "rad/s, rad/s² and rad/s²",
        "The paper prints none. Read in mm the claims hold as well, read as torques they do not: see units.",
    ),
    Assumption(
        "inertia J",
        "3.70e-4 kg·m²: screw and motor with the largest mass of Table 1",
        "The paper prints the parts of it, not the load of its simulations.",
    ),
    Assumption(
        "step of Figure 11",
        "1 mm in 50 ms by a polynomial of the fifth degree, and the bare step",
        "Section 4.2 asks for a reference that can be differentiated n times; the derivatives of the bare step are "
        "commanded as 0.",
    ),
    Assumption(
        "start of the sines", "in motion, in steady sliding on the command", "The paper shows no start of a simulation."
    ),
    Assumption(
        "bound F~ at rest",
        "its static value, F_S",
        "With the sign of a speed that reads 0 at rest only η is left, and the stage sticks: see forms of the law.",
    ),
    Assumption(
        "sampling and sensor of `ours.*`",
        "4 kHz and a scale of 10 nm",
        "The paper samples nothing; its gains ask for more than 200 kHz.",
    ),
    Assumption(
        "play and joint of section 2.1", "2 µm, 1e8 N/m, a guide with 20 N", "The paper draws backlash without numbers."
    ),
    Assumption(
        "stages of the equal searches",
        "F_C 5 to 7.5, F_S 7.5 to 11.2 N·m, J within 20 %; table of 50 to 75 kg with the axial mode",
        "Chosen: the paper knows friction and load exactly. The controllers believe Table 2 throughout.",
    ),
    Assumption(
        "bound on chatter",
        "0.6 N·m RMS from sample to sample, in nine of ten runs",
        "A tenth of the Coulomb friction; a reversal of sin 2πt mm alone takes some 0.36 N·m.",
    ),
    Assumption(
        "torque drive, axial mode, filter of the scale",
        "15 N·m, 0.2 ms, ripple of 1 %, 201 and 266 Hz, 1 kHz",
        "Chosen: usual values of a drive and of a screw of this size.",
    ),
)

STUDY = Study(
    name="fsmc_ballscrew",
    title="Sliding-mode control of a ball-screw stage with LuGre friction, judged by the double ball bar",
    paper=(
        "M. Shams, M. Safdari: Fuzzy Sliding Mode Control of a Ball Screw Driven Stage. In: F. Casolo (ed.), Motion "
        "Control, InTech 2010, ISBN 978-953-7619-55-8."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    folder=Path(__file__).parent,
    contents=contents_of(
        *(f"leadscrew.studies.fsmc_ballscrew.{part}" for part in ("claims", "experiments", "figures"))
    ),
    summary=(
        "Conventional, complementary and fuzzy sliding mode against friction a thousand times the inertia: the order "
        "of the three is reproduced in continuous time, and follows from their gains: with the slope of the fuzzy law "
        "the printed SMC errs less than it. The printed gains ask for 200 kHz; at 4 kHz, tuned by equal searches, the "
        "laws with an integral and the same friction model are compared with a PID and a scheduled PD."
    ),
    record=("plant.speed", "plant.bristle"),
    card=("half_of_the_tight_bound", "csmc_eliminates_it", "fsmc_torque_at_rest.commanded"),
    assumed=ASSUMED,
    method=(
        "The stage is (1) to (5) with Tables 1 and 2, integrated by RODAS with adaptive steps: friction is stiff, with "
        "rates up to 1e6 1/s. The laws of the paper run in continuous time, where they see position and speed exactly; "
        "errors are those of the true position.",
        "The paper prints no number of its simulations, and its Figures 8 to 14 are lost: a sentence about them is "
        "measured as its note states. What is sampled runs at 4 kHz with a scale of 10 nm.",
        "What an engineer would use instead is tuned by equal searches, from rest; each controller file in `tuned` "
        "holds its command. The judge draws other stages.",
        "Circles are drawn by two such stages, and their quantities are those of ISO 230-4.",
    ),
    limits=(
        "All results are for a simulated, rigid stage. Nothing here is evidence about the authors' machine.",
        "Where the stage sticks and slips (SMC on 0.01 sin t mm, most sampled laws there) a largest error depends on "
        "the integrator's last digits.",
        "A sample of delay or an axial mode makes the settings for an ideal drive unstable: see real drives.",
        "Friction is LuGre: it does not age at rest, and forgets where a stage turned before it slides.",
    ),
)
