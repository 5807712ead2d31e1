"""The cascade of the EMPS axis, with the gains and the model of its log."""

from leadscrew.controllers import axis_cascade

MODEL = {
    "acceleration": 2.7057e-3, "viscous": 5.7894e-3, "coulomb_forward": 0.58019, "coulomb_backward": 0.58019,
    "offset": -0.09004, "smooth": 0.5,
}  # fmt: skip
emps_cascade = axis_cascade(
    kpos=160.18, kvp=0.24345, ahead_s=5e-4, lower=-10.0, upper=10.0, **{f"model.{key}": x for key, x in MODEL.items()}
)
