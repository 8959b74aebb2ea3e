"""Policies by file name, by module and class, and as another package registered them."""

import hashlib
import importlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.policy_digest import policy_digest
from lawn_sb3.experiment.registry import REPOSITORY

OWN_POLICY = '''
import torch as th
from lawn_sb3.algos.mappo import CTDEPolicy

class OwnPolicy(CTDEPolicy):
    """A critic that sees nothing but the loads."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local[:, self.layout.cell_loads]
'''


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with ``policies/`` in it, whose modules Python finds for the length of a test."""
    (tmp_path / "policies").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return tmp_path


def test_a_file_in_policies_is_found_by_its_name_and_by_module_and_class() -> None:
    assert find_policy("centralized_critic").__name__ == "CentralizedCriticPolicy"
    assert find_policy("state_critic").__name__ == "StateCriticPolicy"
    assert find_policy("policies.state_critic:StateCriticPolicy") is find_policy("state_critic")


def test_a_file_dropped_into_policies_of_the_working_directory_is_found(folder: Path) -> None:
    (folder / "policies" / "only_here.py").write_text(OWN_POLICY, encoding="utf-8")
    assert find_policy("only_here").__name__ == "OwnPolicy"


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("import nothing_of_that_name", "ModuleNotFoundError"),
        ("class Own(:", "SyntaxError"),
        ("class Own:\npass", "IndentationError"),
        ("\0", "SyntaxError"),
        ("x = 1 / 0", "ZeroDivisionError: division by zero"),
        ("raise SystemExit(0)", "cannot be imported: SystemExit: 0"),
        ("x = 1", r"must hold one policy class, found 0 \(its classes: no class\)"),
        ("class Own:\n    pass", r"found 0 \(its classes: Own\); a policy derives from lawn_sb3"),
        (OWN_POLICY + OWN_POLICY.replace("OwnPolicy", "Another"), "found 2"),
    ],
)
def test_a_broken_policy_file_is_named_in_one_line(folder: Path, source: str, expected: str) -> None:
    (folder / "policies" / "broken.py").write_text(source, encoding="utf-8")
    with pytest.raises(UserError, match=expected) as refusal:
        find_policy("broken")
    assert "broken.py" in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("stat_critic", "did you mean 'state_critic'"),
        ("no.such.module:Policy", "cannot be imported"),
        ("policies.state_critic:Nobody", "no class 'Nobody'"),
        ("lawn_sb3.scenario:Scenario", "not an SB3 policy"),
    ],
)
def test_an_unknown_policy_is_refused(name: str, expected: str) -> None:
    with pytest.raises(UserError, match=expected):
        find_policy(name)


def test_a_file_named_like_one_of_the_kits_own_policies_is_refused_unless_it_is_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find_policy("state_critic")
    monkeypatch.setitem(sys.modules, "policies.state_critic", sys.modules["policies.state_critic"])  # comes back
    source = (REPOSITORY / "policies" / "state_critic.py").read_text(encoding="utf-8")
    (folder / "policies" / "state_critic.py").write_text(source, encoding="utf-8")
    assert find_policy("state_critic").__name__ == "StateCriticPolicy"
    (folder / "policies" / "state_critic.py").write_text(source + "# mine\n", encoding="utf-8")
    with pytest.raises(UserError, match="rename your file"):
        find_policy("state_critic")


SETUP = """
[metadata]
name = {name}
version = 1.0

[options]
py_modules = {module}

[options.entry_points]
lawn_sb3.policies =
    {registered} = {module}:{attribute}
"""


def install(folder: Path, monkeypatch: pytest.MonkeyPatch, registered: str, attribute: str = "OwnPolicy") -> None:
    """Install a tiny package that registers a policy, where Python finds it for the length of a test."""
    source, module = folder / "source", f"tiny_{registered}"
    source.mkdir(parents=True)
    (source / f"{module}.py").write_text(OWN_POLICY, encoding="utf-8")
    setup = SETUP.format(name=f"tiny-{registered}", module=module, registered=registered, attribute=attribute)
    (source / "setup.cfg").write_text(setup, encoding="utf-8")
    (source / "pyproject.toml").write_text('[build-system]\nrequires = ["setuptools"]\n', encoding="utf-8")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, "--target", str(folder / "site"), str(source)], check=True, capture_output=True)
    monkeypatch.syspath_prepend(str(folder / "site"))
    importlib.invalidate_caches()


def test_a_policy_that_an_installed_package_registers_is_found_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch, "loads_only")
    found = find_policy("loads_only")
    assert (found.__module__, found.__name__) == ("tiny_loads_only", "OwnPolicy")
    assert find_policy("tiny_loads_only:OwnPolicy") is found
    with pytest.raises(UserError, match="did you mean 'loads_only'"):
        find_policy("load_only")


def test_a_registered_name_that_a_file_has_too_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch, "relative")
    with pytest.raises(UserError, match=r"both '.*relative.py' and registered by 'tiny-relative' as "):
        find_policy("relative")


def test_a_package_that_registers_something_else_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch, "nobody", attribute="Nobody")
    with pytest.raises(UserError, match=r"policy 'nobody', registered by 'tiny-nobody' .* has no class 'Nobody'"):
        find_policy("nobody")


def test_a_module_beside_the_user_is_found(folder: Path) -> None:
    (folder / "beside_me.py").write_text(OWN_POLICY, encoding="utf-8")
    assert find_policy("beside_me:OwnPolicy").__name__ == "OwnPolicy"


USES = """
from lawn_sb3.algos.mappo import CTDEPolicy
from {module} import {name}

raise RuntimeError("nobody is to import this to hash it")
"""


@pytest.fixture
def digest(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """The digest of a policy as another process would work it out."""

    def fresh(name: str) -> str:
        monkeypatch.setattr("lawn_sb3.experiment.policy_digest._DIGESTS", {})
        importlib.invalidate_caches()
        return policy_digest(name)

    return fresh


def test_the_digest_of_a_file_that_imports_nothing_of_the_users_is_that_of_its_bytes() -> None:
    kept = yaml.safe_load((REPOSITORY / "runs/reference/paper/iql/seed-0/config.yaml").read_text(encoding="utf-8"))
    content = (REPOSITORY / "policies" / "local_q.py").read_bytes()
    assert policy_digest("local_q") == hashlib.sha256(content).hexdigest()[:16] == kept["policy_file"]
    assert policy_digest("policies.local_q:LocalQPolicy") == policy_digest("local_q")


@pytest.mark.parametrize("recipe", ["paper", "ablation", "ladder"])
def test_kept_runs_still_count_as_made_with_the_shipped_policies(recipe: str) -> None:
    for path in sorted((REPOSITORY / "runs" / "reference" / recipe).glob("*/seed-*/config.yaml")):
        kept = yaml.safe_load(path.read_text(encoding="utf-8"))
        name = kept["method"]["policy"]
        assert kept["policy_file"] == (policy_digest(name) if name else None), path


def test_modules_of_the_users_own_that_a_policy_imports_count_and_so_do_those_that_they_import(
    folder: Path, digest: Callable[[str], str]
) -> None:
    (folder / "policies" / "uses_own.py").write_text(USES.format(module="nets_of_mine.deep", name="Net"))
    (folder / "nets_of_mine").mkdir()
    (folder / "nets_of_mine" / "__init__.py").write_text("raise RuntimeError")
    (folder / "nets_of_mine" / "deep.py").write_text("import numpy\nfrom . import shallow\nimport beside_nets\n")
    (folder / "nets_of_mine" / "shallow.py").write_text("from .deep import Net\n")
    (folder / "beside_nets.py").write_text("WIDTH = 64\n")
    (folder / "unused_nets.py").write_text("WIDTH = 64\n")
    before = digest("uses_own")
    package = ("nets_of_mine/__init__.py", "nets_of_mine/deep.py", "nets_of_mine/shallow.py")
    for path in ("policies/uses_own.py", *package, "beside_nets.py"):
        source = (folder / path).read_text()
        (folder / path).write_text(f"{source}# edited\n")
        assert digest("uses_own") != before, path
        (folder / path).write_text(source)
    (folder / "unused_nets.py").write_text("WIDTH = 32\n")
    assert digest("uses_own") == before
    assert not {"nets_of_mine", "beside_nets", "policies.uses_own"} & sys.modules.keys()


def test_a_policy_that_builds_on_one_of_the_kits_own_is_hashed_with_it(
    folder: Path, digest: Callable[[str], str]
) -> None:
    own = folder / "policies" / "on_top.py"
    own.write_text(USES.format(module="policies.state_critic", name="StateCriticPolicy"))
    content = own.read_bytes() + (REPOSITORY / "policies" / "state_critic.py").read_bytes()
    assert digest("on_top") == hashlib.sha256(content).hexdigest()[:16]


def test_a_file_that_cannot_be_read_as_python_has_a_digest_too(folder: Path, digest: Callable[[str], str]) -> None:
    (folder / "policies" / "half_typed.py").write_text("def (")
    assert digest("half_typed") == hashlib.sha256(b"def (").hexdigest()[:16]
    with pytest.raises(UserError, match="cannot be imported: SyntaxError"):
        find_policy("half_typed")


def test_an_edit_after_a_policy_was_found_does_not_change_its_digest(folder: Path) -> None:
    path = folder / "policies" / "found_once.py"
    path.write_text(OWN_POLICY, encoding="utf-8")
    find_policy("found_once")
    before = policy_digest("found_once")
    path.write_text(OWN_POLICY + "# edited\n", encoding="utf-8")
    assert policy_digest("found_once") == before
