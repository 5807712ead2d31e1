"""The comparison of two commits: what it lists, what it leaves out, and that its table of commands is up to date."""

import shlex

import typer

from leadscrew.cli import app
from tests.same import same


def flat(value):
    return dict(same.flatten(value))


def test_every_number_of_a_result_has_a_key():
    found = flat({"a": {"b": [1, 2.5]}, "rows": [{"name": "x", "v": 1}, {"name": "y"}], "none": []})
    assert found == {
        "a.b[0]": 1, "a.b[1]": 2.5, "rows[x].name": "x", "rows[x].v": 1, "rows[y].name": "y", "none[]": 0,
    }  # fmt: skip


def test_a_table_is_compared_cell_by_cell_and_other_text_by_its_hash():
    assert dict(same.of_text("# made\nt,u\n0,0x1p-1\n1,nan\n", []))["u[0]"] == 0.5
    first, second = (dict(same.of_text(f"int x; /* {word} */\n", [])) for word in ("a", "b"))
    assert first["sha256"] != second["sha256"] and first["lines"] == second["lines"] == 1


def test_the_last_bit_and_the_sign_of_zero_are_differences():
    for a, b, expected in (
        (1.0, 1.0 + 2**-52, False), (0.0, -0.0, False), (float("nan"), float("nan"), True), (1, 1.0, True),
        (True, 1, False), ("a", "a", True), (None, 0, False),
    ):  # fmt: skip
        assert same.equal(a, b) is expected, (a, b)


def test_a_difference_names_command_key_and_both_values():
    base = {"tune": {"exit code": 0, "best": 2.0}, "log": {"exit code": 0, "rows": 3}}
    head = {"tune": {"exit code": 0, "best": 2.5, "more": 1}, "log": {"exit code": 2, "message": "no such option"}}
    assert same.compare(base, head) == [
        ("tune", "best", 2.0, 2.5),
        ("tune", "more", "(no such key)", 1),
        ("log", "exit code", 0, 2),
        ("log", "message", None, "no such option"),
    ]
    assert same.relative(2.0, 2.5) == "0.2" and same.relative("a", 1) == ""


def test_renamed_and_excluded_keys_are_no_differences(tmp_path):
    (tmp_path / "renamed.toml").write_text(
        "[words]\n'--old' = '--new'\n[keys]\n'\\.told$' = '.identifiable'\n[values]\n'told' = 'identifiable'\n"
    )
    (tmp_path / "excluded.toml").write_text(
        "[keys]\n'\\bwall_s$' = 'time'\n[files]\n[text]\n'Leadscrew [0-9.]+' = 'version'\n"
    )
    rules = same.Rules(tmp_path)
    base = {"mass.told": True, "verdict": "told", "wall_s": 1.0, "by": "Leadscrew 0.1.0"}
    head = {"mass.identifiable": True, "verdict": "identifiable", "wall_s": 2.0, "by": "Leadscrew 0.2.0"}
    base, head = (rules.kept({"fit": side}) for side in (base, head))
    assert same.compare(rules.in_new_words(base), head) == []
    assert rules.in_old_words("fit log.csv --new 1 --newer 2") == "fit log.csv --old 1 --newer 2"


def test_the_committed_tables_are_read():
    rules = same.Rules()
    assert rules.excluded("simulate lathe: wall_s") and not rules.excluded("simulate lathe: metrics.overshoot")
    assert all(same.table(same.HERE / "excluded.toml")[section] for section in ("keys", "files", "text"))


def test_every_command_of_the_table_exists_with_its_options_and_inputs():
    root = typer.main.get_command(app)
    rows = {**(read := same.table(same.HERE / "commands.toml", "quick", "whole"))["quick"], **read["whole"]}
    assert len(rows) >= 60
    for name, line in rows.items():
        command, words = root, shlex.split(line)
        while hasattr(command, "commands"):
            assert words[0] in command.commands, name
            command = command.commands[words.pop(0)]
        options = {option for p in command.params for option in (*p.opts, *p.secondary_opts)}
        assert {word for word in words if word.startswith("-")} <= options, name
        for word in words:
            folder, _, rest = word.partition(":")[0].partition("/")
            if folder in same.INPUTS and rest:
                assert (same.ROOT / same.INPUTS[folder] / rest).exists(), word


def test_every_subcommand_that_computes_is_in_the_table():
    without = {"demo", "panel", "bench", "version", "cache"}
    rows = " ".join(same.table(same.HERE / "commands.toml")["quick"].values())
    for name in set(typer.main.get_command(app).commands) - without - {"run"}:
        assert name in rows, name
