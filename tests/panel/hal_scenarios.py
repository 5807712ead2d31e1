"""What is done inside ``halrun``: each function is one scenario at the axis of ``docs/panel_hal.md``."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import traceback
from pathlib import Path

import numpy as np

from leadscrew.panel import hal
from leadscrew.panel.hal.attach import Attachment
from leadscrew.util.errors import LeadscrewError

FILE = Path("machine_hal.toml")
KINDS = ("pin", "sig", "param", "comp", "funct", "thread", "alias")


def halcmd(*words):
    return subprocess.run(["halcmd", "-s", *words], capture_output=True, text=True, check=True).stdout


def getp(name):
    return float(halcmd("getp", name))


def seen():
    """All that is in HAL but what changes by itself: names, links, order in threads, and values that nothing drives."""
    rows = {kind: [line.split() for line in halcmd("show", kind).splitlines() if line.split()] for kind in KINDS}
    return {
        "pin": [w[:3] + w[4:] + ([w[3]] if still(w) else []) for w in rows["pin"]],
        "sig": [[w[0], *sorted(w[2:])] for w in rows["sig"]],
        "param": [w[:3] + w[4:] for w in rows["param"]],
        "comp": [w[1:4] for w in rows["comp"] if not w[2].startswith("halcmd")],
        "funct": [[w[0], *w[3:]] for w in rows["funct"]],
        "thread": [[w[0], w[2], *w[5:]] for w in rows["thread"]],
        "alias": rows["alias"],
    }


def still(words):
    """Whether a pin's value changes only when it is written."""
    return words[2] == "IN" and len(words) == 5 and "-deriv" not in words[4] and words[0] != "sampler"


def same(before, after=None):
    """Differences between what was in HAL and what is now; empty: none."""
    after = seen() if after is None else after
    return [[k, x] for k in KINDS for x in (*before[k], *after[k]) if (x in before[k]) != (x in after[k])] + [
        [k, "order"] for k in KINDS if k != "comp" and sorted(before[k]) == sorted(after[k]) and before[k] != after[k]
    ]


def machine(text=None):
    """The panel's machine, attached."""
    from leadscrew.panel.hal.file import parsed

    found = hal.HalMachine(hal.read(FILE) if text is None else parsed(text, "file"), Path("folder"))
    later = found.begin()
    later.done(later.work())
    return found


def spin(found, seconds):
    """Ticks as the panel does; the rows that a page would get."""
    frames, until = [], time.monotonic() + seconds
    while time.monotonic() < until:
        frames += found.tick(time.monotonic())
        time.sleep(0.02)
    return np.concatenate([f.rows for f in frames]) if frames else np.zeros((0, len(found.columns)))


def blocks(attachment, seconds):
    """What is sampled, as blocks of doubles with the number of their first period."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        attachment.pipe.take()
        time.sleep(0.02)
    found, attachment.pipe.blocks = attachment.pipe.blocks, []
    return [[first, rows[:, 0].tolist()] for first, rows in found]


def refused(act, *words, **more):
    try:
        act(*words, **more)
    except LeadscrewError as error:
        return str(error)
    return ""


def cpu(pid):
    words = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def eight(text):
    """The file with eight signals."""
    more = ("pid.x.commandv-unused", "wave.cosine", "wave.triangle", "wave.sawtooth")
    return text.replace(
        "[[parameters]]",
        "".join(f'[[signals]]\nsource = "{name}"\nlabel = "{name}"\n\n' for name in more[1:]) + "[[parameters]]",
        1,
    )


def sampled():
    """Eight signals for some seconds."""
    before = seen()
    found = machine(eight(FILE.read_text()))
    during = seen()
    began, own, helper = time.monotonic(), time.process_time(), cpu(found.attachment.pipe.process.pid)
    rows = spin(found, 4.0)
    took = time.monotonic() - began
    own, helper = time.process_time() - own, cpu(found.attachment.pipe.process.pid) - helper
    state, described = found.state(), found.describe()
    rows = rows.tolist()
    found.close()
    return {"same": same(before), "during": during, "rows": rows, "state": state, "machine": described,
            "took": took, "cpu": own / took, "cpu_helper": helper / took}  # fmt: skip


def written():
    """A gain is changed in the running loop, and what must not be is not."""
    before = seen()
    found = machine()
    error = found.columns.index("pid.x.error")
    told = {"slow": spin(found, 2.0)[-1000:, error].tolist()}
    told["set"] = found.ask("set", {"changes": {"pid.Pgain": 100.0}})
    told["getp"] = getp("pid.x.Pgain")
    spin(found, 0.5)
    told["fast"] = spin(found, 1.2)[-1000:, error].tolist()
    inside = seen()
    wrong = [{"pid.Pgain": 120.5}, {"pid.Pgain": -1e-9}, {"pid.Pgain": float("nan")}, {"pid.Pgain": 1e400},
             {"pid.Pgain": "50"}, {"pid.Pgain": True}, {"pid.x.enable": 0.0}, {"pid.x.Igain": 1.0},
             {"pid.FF1": 0.5, "pid.Pgain": 1000.0}]  # fmt: skip
    told["refused"] = [refused(found.ask, "set", {"changes": changes}) for changes in wrong]
    told["never"] = {do: refused(found.ask, do, {}) for do in ("start", "stop", "reset", "disturb", "x")}
    pipe = found.attachment.pipe
    behind = [{"pid.x.enable": 0}, {"pid.Pgain": 1e6}, {"pid.Pgain": True}]
    told["helper"] = [refused(pipe.ask, "set", values=values) for values in behind]
    told["untouched"] = same(inside)
    halcmd("setp", "pid.x.Pgain", "60")
    spin(found, 1.5)
    told["notices"] = [n[1]["text"] for n in found.news() if n[0] == "notice"]
    told["taken_over"] = found.values["pid.Pgain"]
    found.ask("undo", {})
    told["undone"] = getp("pid.x.Pgain")
    found.ask("redo", {})
    told["redone"] = getp("pid.x.Pgain")
    began = time.monotonic()
    found.ask("set", {"changes": {"pid.FF1": 1.0}})
    told["ramp"] = []
    while time.monotonic() < began + 1.3:
        told["ramp"].append([time.monotonic() - began, getp("pid.x.FF1")])
        time.sleep(0.05)
    found.ask("safe", {"why": "time-out"})
    spin(found, 1.3)
    told["safe"] = [getp("pid.x.Pgain"), getp("pid.x.FF1")]
    found.ask("set", {"changes": {"pid.Pgain": 33.0}})
    found.close()
    told["left"] = [getp("pid.x.Pgain"), getp("pid.x.FF1")]
    told["same"] = same(before)
    return told


def kept():
    """``on_leave = "keep"`` leaves what was written; too many writes in a second are refused."""
    found = machine(FILE.read_text().replace('on_leave = "safe"', 'on_leave = "keep"'))
    said = [refused(found.ask, "set", {"changes": {"pid.Pgain": 20.0 + i}}) for i in range(25)]
    last = found.values["pid.Pgain"]
    found.close()
    return {"said": said, "last": last, "getp": getp("pid.x.Pgain")}


def hold():
    """A panel that is there until it is killed."""
    found = machine()
    found.ask("set", {"changes": {"pid.Pgain": 100.0}})
    Path("held.json").write_text(json.dumps([os.getpid(), found.attachment.pipe.process.pid]))
    spin(found, 60.0)


def panel_to_kill():
    Path("held.json").unlink(missing_ok=True)
    child = subprocess.Popen([sys.executable, "-m", "tests.panel.hal_scenarios", "hold", "hold.json"])
    until = time.monotonic() + 20.0
    while not Path("held.json").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.3)
    return child, json.loads(Path("held.json").read_text())[1]


def killed():
    """The panel's process is killed; then the helper with it."""
    before = seen()
    child, helper = panel_to_kill()
    gain = getp("pid.x.Pgain")
    another = refused(machine)
    child.kill()
    child.wait()
    until = time.monotonic() + 10.0
    while Path(f"/proc/{helper}").exists() and time.monotonic() < until:
        time.sleep(0.02)
    told = {"gain": gain, "another": another, "same": same(before), "after": getp("pid.x.Pgain"),
            "ended": not Path(f"/proc/{helper}").exists()}  # fmt: skip
    child, helper = panel_to_kill()
    os.kill(helper, signal.SIGKILL)
    child.kill()
    child.wait()
    time.sleep(0.2)
    told["left_over"] = same(before)
    found = machine()
    told["said"] = [n[1]["text"] for n in found.news() if n[0] == "notice"]
    told["rows"] = len(spin(found, 1.0))
    found.ask("set", {"changes": {"pid.Pgain": 100.0}})
    helper = found.attachment.pipe.process.pid
    os.kill(helper, signal.SIGKILL)
    spin(found, 0.2)
    told["state"] = found.state()
    told["lost_helper"] = refused(found.ask, "set", {"changes": {"pid.Pgain": 50.0}})
    found.close()
    machine().close()
    after = seen()
    after["comp"] = [c for c in after["comp"] if not c[1].startswith("leadscrew-panel")]
    told["again"] = same(before, after)
    return told


def overrun():
    """The reader stands still for longer than the FIFO holds."""
    from leadscrew.panel.hal.file import parsed

    text = FILE.read_text().replace("window_s", "buffer_s = 0.5\nwindow_s")
    attachment = Attachment(parsed(text, "file"))
    attachment.attach()
    helper = attachment.pipe.process.pid
    found = blocks(attachment, 0.7)
    for pause in (1.0, 1.4):
        os.kill(helper, signal.SIGSTOP)
        time.sleep(pause)
        os.kill(helper, signal.SIGCONT)
        found += blocks(attachment, 0.7)
    attachment.leave()
    shown = machine(text)
    shown.ask("arm", {"signal": "x-pos-cmd", "level": 0.0, "slope": "rising", "mode": "single", "pre": 0.5,
                      "length_s": 0.2})  # fmt: skip
    helper = shown.attachment.pipe.process.pid
    rows = spin(shown, 0.5)
    os.kill(helper, signal.SIGSTOP)
    time.sleep(1.0)
    os.kill(helper, signal.SIGCONT)
    rows = np.concatenate([rows, spin(shown, 1.0)])
    broken = int(np.isnan(rows).all(axis=1).sum())
    news, lost, period = shown.news(), shown.lost, shown.period
    shown.close()
    return {"blocks": found, "broken": broken, "lost": lost, "period": period, "rows": len(rows),
            "notices": [n[1]["text"] for n in news if n[0] == "notice"],
            "captures": [n[1]["capture"] for n in news if n[0] == "capture"]}  # fmt: skip


def shared():
    """A sampler of somebody else: its free channel is used, and left as it was."""
    before = seen()
    reader = subprocess.Popen(["halsampler", "-c", "0", "-t", "-n", "3000", "theirs.txt"])
    time.sleep(0.3)
    attachment = Attachment(hal.read(FILE))
    attachment.attach()
    ours = blocks(attachment, 3.5)
    reader.wait(10)
    attachment.leave()
    theirs = [line.split() for line in Path("theirs.txt").read_text().splitlines()]
    return {"ours": ours, "theirs": theirs, "same": same(before)}


def taken():
    """A sampler of somebody else without a free channel."""
    before = seen()
    return {"said": refused(Attachment(hal.read(FILE)).attach), "same": same(before)}


def attached_and_left(text):
    machine(text).close()


def faults():
    """Files that do not fit this HAL: refused with a sentence, and HAL untouched."""
    halcmd("alias", "pin", "home-delay.on-delay", "gain.x")
    before = seen()
    good = FILE.read_text()
    wrong = json.loads(Path("wrong.json").read_text())
    said = []
    for old, new in wrong:
        assert old in good, old
        said.append([new, refused(attached_and_left, good.replace(old, new)), same(before)])
    return {"said": said}


def latency():
    """From the change of a parameter to the first tick that shows what it did."""
    text = FILE.read_text() + '\n[[parameters]]\nkey = "pid.bias"\nhal = "pid.x.bias"\nlow = 0.0\nhigh = 60.0\n'
    found = machine(text)
    column = found.columns.index("x-vel-cmd")
    level, shown = spin(found, 0.5)[-1, column], []
    for k in range(30):
        found._writes.clear()
        frames = [f for f in found.tick(time.monotonic()) if len(f.rows)]
        level = frames[-1].rows[-1, column] if frames else level
        time.sleep(0.013 + 0.001 * k)
        found.ask("set", {"changes": {"pid.bias": 50.0 if k % 2 == 0 else 0.0}})
        ticks = 0
        while (ticks := ticks + 1) < 100:
            time.sleep(0.02)
            frames = [f for f in found.tick(time.monotonic()) if len(f.rows)]
            steps = [np.abs(np.diff(f.rows[:, column], prepend=level)).max() for f in frames]
            level = frames[-1].rows[-1, column] if frames else level
            if steps and max(steps) > 30.0:
                break
        shown.append(ticks)
    found.close()
    return {"shown": sorted(shown)}


def served():
    """The whole panel: the command, a page, a change, Ctrl-C."""
    from tests.panel.served import Served

    before = seen()
    panel = Served(Path("folder").absolute(), "--hal", str(FILE.absolute()))
    page = panel.page()
    told = {"taken": page.ask("take")}
    page.listen(2.0)
    told["machine"] = page.machine if hasattr(page, "machine") else {}
    told["set"] = page.ask("set", changes={"pid.Pgain": 100.0})
    page.listen(1.5)
    told["getp"] = getp("pid.x.Pgain")
    told["start"] = page.ask("start")
    told["rows"] = [x.tolist() for x in page.column("pid.x.error")]
    page.close()
    told["code"] = panel.end()
    until = time.monotonic() + 10.0
    while same(before) and time.monotonic() < until:
        time.sleep(0.1)
    return told | {"same": same(before), "left": getp("pid.x.Pgain")}


def in_browser():
    """The page in Chromium: what a person sees, and a gain typed in."""
    from tests.panel.browser.chrome import Browsers
    from tests.panel.served import Served

    panel, browsers = Served(Path("folder").absolute(), "--hal", str(FILE.absolute())), Browsers()
    try:
        with browsers.view(panel) as view:
            view.in_control()
            view.until("panel.state.period > 3000")
            view.parameter("pid.Pgain", 100)
            told = {"getp": getp("pid.x.Pgain")}
            view.until(f"panel.state.period > {view.js('() => panel.state.period') + 2000}")
            told["notice"] = view.page.inner_text("body")
            told["buttons"] = view.js(
                "() => ['start', 'stop', 'reset', 'hold'].map(n => document.getElementById(n)?.disabled ?? true)"
            )
            view.picture("hal_live")
            told["seen"] = view.history("pid.x.error")["pid.x.error"].tolist()
            told["wrong"] = view.wrong
    finally:
        browsers.close()
        panel.end()
    return told


def main(name, out):
    try:
        told = globals()[name]()
    except BaseException:
        told = {"error": traceback.format_exc()}
    Path(out).write_text(json.dumps(told))


if __name__ == "__main__":
    main(*sys.argv[1:])
