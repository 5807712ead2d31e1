"""Which controller a certificate is about: any change of it is another one."""

from leadscrew.export.controller import identity_of
from leadscrew.kernel.loop import Loop
from tests.kernel import zoo

GIVEN = {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.mass, "metrics": {}}


def test_a_certificate_of_another_gain_period_or_law_has_another_fingerprint():
    base = identity_of(Loop(**GIVEN))
    gain, period, law = (
        identity_of(Loop(**{**GIVEN, **change}))
        for change in ({"controller": zoo.pid(kp=1.0)}, {"period": 2e-3}, {"controller": zoo.history})
    )
    assert len({x["fingerprint"] for x in (base, gain, period, law)}) == 4
    assert base["source_hash"] == gain["source_hash"] == period["source_hash"] != law["source_hash"]
    assert identity_of(Loop(**{**GIVEN, "plant": zoo.mass(mass=3.0)})) == base
    assert (period["period_s"], gain["parameters"]["kp"]) == (2e-3, 1.0)
