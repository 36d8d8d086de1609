"""Arguments of the kernels: what is not a plain float64 array gives the same bits or a clear error, never a crash."""

import gc
import re
import sys
import threading
import weakref

import mpmath
import numpy as np
import pytest

import kinestatics as ks
from kinestatics import kernels
from kinestatics._kernels import _core

ARM = ks.load("ur5e")
EV = ks.Evaluator(ARM)
Q = np.random.default_rng(0).uniform(-3, 3, (40, 6))
EXPECTED = EV.jacobian(Q)


class Subclass(np.ndarray):
    """A subclass that changes nothing."""


def layouts(tmp_path):
    mapped = np.memmap(tmp_path / "q.bin", dtype=np.float64, mode="w+", shape=Q.shape)
    mapped[:] = Q
    wide = np.zeros((40, 12))
    wide[:, ::2] = Q
    unaligned = np.frombuffer(b"\0" + Q.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(Q.shape)
    frozen = Q.copy()
    frozen.setflags(write=False)
    return {
        "fortran": np.asfortranarray(Q),
        "strided": wide[:, ::2],
        "reversed": Q[::-1].copy()[::-1],
        "memory-mapped": mapped,
        "subclass": Q.view(Subclass),
        "read-only": frozen,
        "unaligned": unaligned,
        "big-endian": Q.astype(">f8"),
        "list": Q.tolist(),
    }


def test_every_layout_gives_the_same_bits(tmp_path):
    """Layout, alignment, byte order and class of the input do not matter; the input is not changed."""
    for name, array in layouts(tmp_path).items():
        before = np.array(array, copy=True)
        assert np.array_equal(EV.jacobian(array), EXPECTED), name
        assert np.array_equal(np.asarray(array), before), name


def test_repeated_rows_by_stride_zero():
    """A broadcast array (stride 0) is a batch of equal configurations."""
    result = EV.jacobian(np.broadcast_to(Q[0], (70, 6)))
    assert np.array_equal(result, np.repeat(EXPECTED[:1], 70, axis=0))


def test_integers_booleans_and_halves_become_double():
    """Whole numbers, booleans and half precision are computed in double."""
    whole = np.array([[1, 0, -1, 2, 0, 1]])
    assert np.array_equal(EV.jacobian(whole), EV.jacobian(whole.astype(float)))
    assert EV.jacobian(whole > 0).dtype == np.float64
    assert EV.jacobian(whole.astype(np.float16)).dtype == np.float64


def test_single_precision_stays_single():
    """float32 in, float32 out, right to 1e-5."""
    result = EV.jacobian(Q.astype(np.float32))
    assert result.dtype == np.float32
    np.testing.assert_allclose(result, EXPECTED, atol=1e-5)
    assert ks.jacobian(ARM, Q.astype(np.float32)).array.dtype == np.float32


@pytest.mark.parametrize(
    ("array", "code"),
    [
        (np.ma.masked_array(Q, mask=Q > 0), "KS302"),
        (Q.astype(complex), "KS302"),
        (Q.astype(str), "KS302"),
        (np.array([None] * 6), "KS302"),
        ("text", "KS302"),
        (Q[:, :5], "KS303"),
        (Q[0, :, None], "KS303"),
        (np.zeros(()), "KS303"),
        (1.5, "KS303"),
        (np.zeros((40, 7)), "KS303"),
    ],
)
def test_wrong_input_is_a_clear_error(array, code):
    """Wrong kinds and shapes are errors with a code that say what was expected."""
    for method in (EV.jacobian, EV.pose, EV.hessian, EV.gravity_torques, EV.singular_values):
        with pytest.raises(ks.KinestaticsError, match=code):
            method(array)


@pytest.mark.parametrize(
    ("out", "code"),
    [
        (np.zeros((39, 6, 6)), "KS304"),
        (np.zeros((40, 36)), "KS304"),
        (np.zeros((40, 6, 6), dtype=np.float32), "KS304"),
        (np.zeros((40, 6, 12))[:, :, ::2], "KS304"),
        (np.asfortranarray(np.zeros((40, 6, 6))), "KS304"),
        (np.broadcast_to(np.zeros(6), (40, 6, 6)), "KS304"),
        ("text", "KS304"),
        ([0.0], "KS304"),
    ],
)
def test_wrong_out_is_a_clear_error(out, code):
    """out= must be exactly the result's array."""
    with pytest.raises(ks.KinestaticsError, match=code):
        EV.jacobian(Q, out=out)


def test_out_that_shares_memory_with_the_input_is_refused():
    """Writing over the input while reading it would give wrong numbers."""
    memory = np.zeros(40 * 36)
    q = memory[: 40 * 6].reshape(40, 6)
    with pytest.raises(ks.ConfigurationError, match="KS305"):
        EV.jacobian(q, out=memory.reshape(40, 6, 6))


def test_out_is_returned_and_filled():
    """out= comes back as the result itself."""
    out = np.full((40, 6, 6), np.nan)
    assert EV.jacobian(Q, out=out) is out
    assert np.array_equal(out, EXPECTED)
    assert EV.jacobian(Q, out) is out


@pytest.mark.parametrize(
    ("call", "pattern"),
    [
        (EV.jacobian, "needs the argument 'q'"),
        (lambda: EV.jacobian(Q, None, 1, 2), "takes 3 arguments"),
        (lambda: EV.jacobian(Q, wrong=1), "unexpected or repeated argument 'wrong'"),
        (lambda: EV.jacobian(Q, q=Q), "unexpected or repeated argument 'q'"),
        (lambda: EV.jacobian(Q, threads="two"), "integer"),
    ],
)
def test_wrong_calls_are_type_errors(call, pattern):
    """Missing, surplus and unknown arguments are named."""
    with pytest.raises(TypeError, match=pattern):
        call()


def test_numbers_out_of_range():
    """threads >= 1, damping >= 0 and finite."""
    with pytest.raises(ks.ConfigurationError, match="KS306"):
        EV.jacobian(Q, threads=0)
    for damping in (-1.0, np.nan, np.inf):
        with pytest.raises(ks.ConfigurationError, match="KS307"):
            EV.damped_rates(Q, np.zeros(6), damping)
    with pytest.raises(ks.ConfigurationError, match=re.compile("KS303.*twist")):
        EV.damped_rates(Q, np.zeros((39, 6)), 0.1)


def test_one_twist_for_all():
    """A single wrench or twist goes with every configuration of a batch."""
    twist = np.arange(6.0)
    assert np.array_equal(EV.damped_rates(Q, twist, 0.1), EV.damped_rates(Q, np.tile(twist, (40, 1)), 0.1))


@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 3), (0,), (2, 0, 3)])
def test_batch_axes(shape):
    """Leading axes of any number and size, empty ones too."""
    q = np.zeros((*shape, 6))
    twist = np.zeros((*shape, 6))
    assert EV.jacobian(q).shape == (*shape, 6, 6)
    assert EV.pose(q).shape == (*shape, 4, 4)
    assert EV.hessian(q).shape == (*shape, 6, 6, 6)
    assert EV.jacobian_rate(q, q).shape == (*shape, 6, 6)
    assert EV.gravity_torques(q).shape == (*shape, 6)
    assert EV.joint_torques(q, twist).shape == (*shape, 6)
    assert EV.manipulability(q).shape == shape
    assert EV.singular_values(q).shape == (*shape, 6)
    assert EV.damped_rates(q, twist, 0.1).shape == (*shape, 6)


def test_nan_and_infinity_never_become_finite():
    """A configuration that is not finite gives NaN in what depends on it, and leaves its neighbours alone."""
    for poison in (np.nan, np.inf, -np.inf):
        for count in (1, 3, 20):
            q = Q[:count].copy()
            q[0, 1] = poison
            J = EV.jacobian(q)
            assert np.all(np.isnan(J[0, :3, 0]))
            assert np.all(np.isnan(EV.pose(q)[0, :3, 3]))
            assert np.array_equal(J[1:], EXPECTED[1:count])


def test_sines_to_two_units_in_the_last_place():
    """sin and cos against 60 digits: at most 2 ulp up to 1e5, right beyond."""
    rng = np.random.default_rng(1)
    x = np.concatenate(
        [rng.uniform(-4, 4, 800), rng.uniform(-1e5, 1e5, 800), np.arange(-40, 40) * np.pi / 2, [1e8, 1e15, -3e300]]
    )
    mpmath.mp.dps = 400
    for name in ks.kernels.instruction_sets():
        with ks.kernels.use(name):
            for found, function in zip(_core.sincos(x), (mpmath.sin, mpmath.cos), strict=True):
                exact = [function(mpmath.mpf(float(v))) for v in x]
                error = [
                    abs(mpmath.mpf(float(a)) - e) / mpmath.mpf(float(np.spacing(abs(float(e)))))
                    for a, e in zip(found, exact, strict=True)
                ]
                assert max(error[:-3]) <= 2, name
                assert max(error[-3:]) <= 2, name


def test_instruction_sets():
    """An unknown one is refused, and the one in use is restored."""
    before = ks.kernels.instruction_set()
    with pytest.raises(ValueError, match="no instruction set"), ks.kernels.use("abacus"):
        pass
    with ks.kernels.use("baseline"):
        assert ks.kernels.instruction_set() == "baseline"
    assert ks.kernels.instruction_set() == before


def test_large_results_are_independent_and_outlive_their_maker():
    """Results from the pool do not share memory while alive, and stay right when everything else is gone."""
    q = np.tile(Q, (200, 1))
    evaluator = ks.Evaluator(ARM)
    first, second = evaluator.jacobian(q), evaluator.jacobian(q)
    assert not np.shares_memory(first, second)
    part = first[10]
    del first, evaluator
    gc.collect()
    third = EV.jacobian(q + 1)
    assert np.array_equal(part, EXPECTED[10])
    assert not np.shares_memory(third, second)
    assert np.array_equal(second, np.tile(EXPECTED, (200, 1, 1)))
    ks.kernels.release_memory()


def test_references_do_not_leak():
    """Ten thousand calls and errors leave the reference counts of their arguments alone."""
    q, out = Q.copy(), np.zeros((40, 6, 6))
    counts = sys.getrefcount(q), sys.getrefcount(out), sys.getrefcount(EV)
    for _ in range(10_000):
        EV.jacobian(q, out=out)
        EV.manipulability(q)
    for _ in range(200):
        with pytest.raises(ks.ConfigurationError):
            EV.jacobian(q[:, :5], out=out)
    assert (sys.getrefcount(q), sys.getrefcount(out), sys.getrefcount(EV)) == counts
    evaluator = ks.Evaluator(ARM)
    alive = weakref.ref(evaluator)
    del evaluator
    gc.collect()
    assert alive() is None


def test_two_python_threads_on_one_evaluator():
    """The GIL is released; two threads on one object give the same bits."""
    q = np.random.default_rng(3).normal(size=(20_000, 6))
    expected = EV.jacobian(q)
    results = [None] * 4

    def work(i):
        results[i] = [np.array_equal(EV.jacobian(q), expected) for _ in range(5)]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [[True] * 5] * 4


def test_a_chain_refuses_bytes_that_do_not_fit():
    """Programs are checked when they are made: no index out of range can reach the kernels."""
    good = ks.kernels.chain_arguments(ARM, ARM.link("tip"))
    joints = np.frombuffer(good[0], dtype=ks.kernels.JOINT).copy()
    joints["column"][0] = 99
    for bad in (
        (joints.tobytes(), *good[1:]),
        (good[0][:-1], *good[1:]),
        (*good[:5], b"", *good[6:]),
        (*good[:7], b"\xff" * 4, good[8]),
        (*good[:7], good[7][:-1], good[8]),
        (*good[:8], 7),
        (*good[:8], -1),
    ):
        with pytest.raises(ValueError, match=r"do not fit|out of range|whole number"):
            ks.kernels.Chain(*bad)
    with pytest.raises((ValueError, RuntimeError, TypeError)):
        ks.kernels.Chain.__new__(ks.kernels.Chain).jacobian(Q)


def bounded_arrays(n):
    return [np.zeros(n), np.zeros(6), np.zeros(8 + 4 * n), np.zeros(6 + 10 * n + n * n)]


@pytest.mark.parametrize("place", range(4))
def test_a_bounded_program_writes_into_nothing_that_does_not_fit(place):
    """Wrong sizes, types, layouts and read-only results are refused before anything is written."""
    chain = _core.Chain(*kernels.chain_arguments(ARM, ARM.link("tip")))
    good = bounded_arrays(6)
    assert chain.bounded_program(*good)
    frozen = good[3].copy()
    frozen.setflags(write=False)
    bad = [good[place][:-1].copy(), good[place].astype(np.float32), np.zeros(2 * len(good[place]))[::2], good[place][None]]
    for wrong in [*bad, None, 3.0] + ([frozen] if place == 3 else []):
        arrays = list(good)
        arrays[place] = wrong
        assert not chain.bounded_program(*arrays)
    for value in (np.nan, np.inf):
        arrays = bounded_arrays(6)
        arrays[0][2] = value
        assert not chain.bounded_program(*arrays)
    arrays = bounded_arrays(6)
    arrays[1][2] = -np.inf
    assert not chain.bounded_program(*arrays)
    with pytest.raises(TypeError, match="4 arguments"):
        chain.bounded_program(*good[:3])
