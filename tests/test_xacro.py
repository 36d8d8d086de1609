"""The xacro reader: refused unless trusted, bounded when trusted, and every failure a RobotFileError."""

import dataclasses
import json
import os
import re
import subprocess
import sys
import time

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.robots import xacro

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="{3} 0 0"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="2" velocity="3"/></joint>'
)
SECRET = "the-known-word"
SEGMENTS = (
    HEAD
    + '<xacro:macro name="segment" params="i length"><link name="l${i + 1}"/>'
    + JOINT.format("j${i}", "l${i}", "l${i + 1}", "${length}")
    + "</xacro:macro></robot>"
)
ARM = (
    HEAD
    + '<xacro:include filename="$(find arm_description)/urdf/parts/segment.xacro"/>'
    + '<xacro:property name="numbers" value="${xacro.load_yaml(\'parts/numbers.yaml\')}"/>'
    + '<xacro:arg name="first" default="0.5"/><link name="l0"/>'
    + '<xacro:segment i="0" length="$(arg first)"/><xacro:segment i="1" length="${numbers[\'second\'] * 2}"/></robot>'
)


@pytest.fixture
def package(tmp_path):
    """A ROS package with one arm of two joints in three files."""
    parts = tmp_path / "arm_description" / "urdf" / "parts"
    parts.mkdir(parents=True)
    (tmp_path / "arm_description" / "package.xml").write_text("<package/>", encoding="utf-8")
    (parts / "segment.xacro").write_text(SEGMENTS, encoding="utf-8")
    (parts / "numbers.yaml").write_text("second: 0.75\n", encoding="utf-8")
    (parts.parent / "arm.xacro").write_text(ARM, encoding="utf-8")
    return tmp_path / "arm_description"


def test_trusted_file_is_expanded(package):
    """Macros, arguments, YAML, includes and $(find) give the arm that they describe."""
    arm = ks.load(package / "urdf" / "arm.xacro", allow_xacro=True)
    assert arm.joint_names == ("j0", "j1")
    np.testing.assert_allclose(ks.pose(arm, [0.0, 0.0]).translation, [0.5 + 2 * 0.75, 0, 0], atol=1e-15)
    np.testing.assert_array_equal(arm.effort_limits, [2, 2])


def test_xacro_is_refused_without_permission(package):
    """Without allow_xacro nothing runs, and the remedy is named."""
    with pytest.raises(ks.RobotFileError, match=re.compile(r"KS113.*allow_xacro=True.*--allow-xacro", re.DOTALL)):
        ks.load(package / "urdf" / "arm.xacro")


@pytest.mark.parametrize("layout", ["root above the package", "root is the package"])
def test_packages_are_found_in_the_roots(package, tmp_path, layout):
    """$(find NAME) of another package is looked up in the roots that the user names, and nowhere else."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    path = elsewhere / "other.xacro"
    path.write_text(ARM.replace("parts/numbers.yaml", "numbers.yaml"), encoding="utf-8")
    (elsewhere / "numbers.yaml").write_text("second: 0.25\n", encoding="utf-8")
    with pytest.raises(ks.RobotFileError, match=re.compile(r"KS181.*arm_description.*package_roots", re.DOTALL)):
        ks.load(path, allow_xacro=True)
    root = tmp_path if layout == "root above the package" else package
    arm = ks.load(path, allow_xacro=True, package_roots=[root])
    np.testing.assert_allclose(ks.pose(arm, [0.0, 0.0]).translation, [1, 0, 0], atol=1e-15)


def doubling(levels):
    macros = ['<xacro:macro name="m0"><link name="a"/></xacro:macro>']
    macros += [f'<xacro:macro name="m{i}"><xacro:m{i - 1}/><xacro:m{i - 1}/></xacro:macro>' for i in range(1, levels)]
    return HEAD + "".join(macros) + f"<xacro:m{levels - 1}/></robot>"


def attacks(marker, secret):
    """The fourteen, {name: (text, what may come of it with permission)}; they may make an empty file or read one."""
    name = HEAD + '<link name="{}"/></robot>'
    touch = f"touch {marker}"
    subclasses = (
        "${[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"
        f".__init__.__globals__['system']('{touch}')}}"
    )
    frame = f"${{[g for g in [(1 for x in [0])]][0].gi_frame.f_builtins['open']('{marker}', 'w')}}"
    laughs = "".join(f'<!ENTITY x{i} "{f"&x{i - 1};" * 10}">' for i in range(1, 10))
    return {
        "import": (name.format(f"${{__import__('os').system('{touch}')}}"), "KS194"),
        "subclasses": (name.format(subclasses), "KS194"),
        "lambda globals": (name.format("${(lambda: 0).__globals__}"), "KS194"),
        "eval": (name.format(f"$(eval __import__('os').system('{touch}'))"), "KS194"),
        "generator frame": (name.format(frame), "KS194"),
        "nested lambda": (name.format("${(lambda: ().__class__.__name__)()}"), "tuple"),
        "load a file": (name.format(f"${{xacro.load_yaml('{secret}')['k']}}"), "KS111"),
        "environment": (name.format("$(env HOME)"), "KS194"),
        "absolute include": (HEAD + f'<xacro:include filename="{secret}"/></robot>', "KS111"),
        "power": (name.format("${9**9**9}"), "KS108"),
        "macro doubling": (doubling(24), "KS108"),
        "recursion": (
            HEAD + '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/></robot>',
            "KS194",
        ),
        "external entity": (f'<!DOCTYPE r [<!ENTITY x SYSTEM "file://{secret}">]>{HEAD}<m>&x;</m></robot>', "KS110"),
        "billion laughs": (f'<!DOCTYPE r [<!ENTITY x0 "lol">{laughs}]>{HEAD}<m>&x9;</m></robot>', "KS110"),
    }


NAMES = list(attacks("marker", "secret"))


@pytest.fixture
def attack(tmp_path):
    """Writes one of the fourteen into a model folder, with a secret file outside; returns a function of its name."""
    marker, secret = tmp_path / "marker", tmp_path / "secret.yaml"
    secret.write_text(f"k: {SECRET}\n", encoding="utf-8")
    (tmp_path / "model").mkdir()

    def write(name):
        text, expected = attacks(marker, secret)[name]
        path = tmp_path / "model" / "attack.xacro"
        path.write_text(text, encoding="utf-8")
        return path, expected, marker

    return write


def test_there_are_fourteen():
    """All the expressions of the study are here."""
    assert len(NAMES) == 14


@pytest.mark.parametrize("name", NAMES)
def test_attack_without_permission(attack, name):
    """Without permission the file is refused at once and nothing happens."""
    path, _, marker = attack(name)
    began = time.monotonic()
    with pytest.raises(ks.RobotFileError, match="KS113"):
        ks.load(path)
    assert time.monotonic() - began < 0.5
    assert not marker.exists()


@pytest.mark.parametrize("name", NAMES)
def test_attack_with_permission(attack, name):
    """With permission the child ends within 12 s, has touched nothing, and gives a robot or a RobotFileError."""
    path, expected, marker = attack(name)
    began = time.monotonic()
    if expected == "tuple":  # what the filter of xacro lets through: any code; here only a harmless name
        assert ks.load(path, allow_xacro=True).base == expected
    else:
        with pytest.raises(ks.RobotFileError, match=expected) as raised:
            ks.load(path, allow_xacro=True)
        assert SECRET not in str(raised.value)
        assert os.environ["HOME"] not in str(raised.value).replace(str(path), "")
    assert time.monotonic() - began < 13.0  # 12 s and the start of an interpreter
    assert not marker.exists()


@pytest.mark.parametrize(
    ("act", "code"),
    [
        ("open('{0}')", "KS111"),
        ("open('{0}', 'w')", "KS194"),
        ("open('{1}/new', 'w')", "KS194"),
        ("__import__('os').system('touch {0}')", "KS194"),
        ("__import__('os').listdir('{2}')", "KS111"),
        ("__import__('subprocess').run(['touch', '{0}'])", "KS194"),
        ("__import__('socket').socket()", "KS194"),
        ("__import__('os').fork()", "KS194"),
        ("__import__('os').remove('{1}/attack.xacro')", "KS194"),
        ("__import__('ctypes').CDLL(None)", "KS194"),
        ("__import__('sys').exit(0)", "KS194"),
        ("__import__('os')._exit(0)", "KS192"),
        ("__import__('os').kill(__import__('os').getpid(), 9)", "KS194"),
    ],
)
def test_code_that_runs_is_still_watched(tmp_path, act, code):
    """Past the filter of xacro, in a nested lambda, files, processes and connections are refused; nothing is written."""
    folder = tmp_path / "model"
    folder.mkdir()
    reach = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0].__init__.__globals__"
    act = act.format(tmp_path / "marker", folder, tmp_path)
    act = re.sub(r"\b(__import__|open)\(", rf"{reach}['__builtins__']['\1'](", act)
    path = folder / "attack.xacro"
    path.write_text(f'{HEAD}<link name="${{(lambda: {act})()}}"/></robot>', encoding="utf-8")
    with pytest.raises(ks.RobotFileError, match=code):
        ks.load(path, allow_xacro=True)
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["attack.xacro", "model"]


def test_file_next_to_a_symbolic_link_stays_outside(package, tmp_path):
    """A link out of the model folder is followed before it is judged."""
    secret = tmp_path / "secret.yaml"
    secret.write_text("second: 1\n", encoding="utf-8")
    numbers = package / "urdf" / "parts" / "numbers.yaml"
    numbers.unlink()
    numbers.symlink_to(secret)
    with pytest.raises(ks.RobotFileError, match="KS111"):
        ks.load(package / "urdf" / "arm.xacro", allow_xacro=True)


def test_folder_above_is_no_package_by_its_name_alone(package):
    """$(find NAME) reaches a folder above the model only where a package.xml says that it is one."""
    (package / "package.xml").unlink()
    with pytest.raises(ks.RobotFileError, match="KS181"):
        ks.load(package / "urdf" / "arm.xacro", allow_xacro=True)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds the address space of a process")
def test_limit_on_memory(package):
    """An expression that needs more memory than the child may have is an error with the limit."""
    path = package / "urdf" / "arm.xacro"
    path.write_text(f"{HEAD}<link name=\"${{len('x' * 600000000)}}\"/></robot>", encoding="utf-8")
    with pytest.raises(ks.RobotFileError, match=r"KS108.*512 MB of memory"):
        ks.load(path, allow_xacro=True)


def test_process_that_will_not_end_is_ended(package, monkeypatch):
    """The wall time holds where the child waits instead of computing."""
    path = package / "urdf" / "arm.xacro"
    sleep = "().__class__.__base__.__subclasses__()"
    reach = f"[c for c in {sleep} if c.__name__ == '_wrap_close'][0].__init__.__globals__['__builtins__']['__import__']"
    path.write_text(f"{HEAD}<link name=\"${{(lambda: {reach}('time').sleep(60))()}}\"/></robot>", encoding="utf-8")
    monkeypatch.setattr(xacro, "LIMITS", dataclasses.replace(xacro.LIMITS, wall=1.0))
    began = time.monotonic()
    with pytest.raises(ks.RobotFileError, match=r"KS108.*wall time"):
        ks.load(path, allow_xacro=True)
    assert time.monotonic() - began < 5.0


def test_missing_package_is_named(package, monkeypatch):
    """Without xacro the error says which command installs it."""
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(ks.MissingExtraError, match=re.compile(r"KS400.*kinestatics\[xacro\]", re.DOTALL)):
        ks.load(package / "urdf" / "arm.xacro", allow_xacro=True)


def test_output_is_read_strictly(package):
    """What xacro makes goes through the URDF reader: a wrong robot has its usual code."""
    path = package / "urdf" / "arm.xacro"
    path.write_text(f'{HEAD}<link name="a"/><link name="${{\'a\'}}"/></robot>', encoding="utf-8")
    with pytest.raises(ks.RobotFileError, match="KS130"):
        ks.load(path, allow_xacro=True)


def test_users_process_never_imports_xacro(package):
    """Xacro and YAML stay in the child; the user's process opens nothing outside the model's package and the libraries."""
    code = f"""
import json, sys
import kinestatics as ks
from kinestatics.robots import bounded, loading, urdf, xacro
import subprocess, threading
opened = []
sys.addaudithook(lambda event, a: opened.append(str(a[0])) if event == "open" and isinstance(a[0], str) else None)
ks.load({str(package / "urdf" / "arm.xacro")!r}, allow_xacro=True)
print(json.dumps([sorted({{"xacro", "yaml"}} & set(sys.modules)), opened]))
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    imported, opened = json.loads(answer)
    assert not imported
    libraries = (str(package), sys.prefix, sys.base_prefix, os.path.dirname(ks.__file__), "/dev/null")
    assert any(path.endswith("arm.xacro") for path in opened)
    assert not [
        path for path in opened if not os.path.realpath(path).startswith(libraries) and not path.startswith(libraries)
    ]
