// The Python type `Chain`, bound by hand to the CPython limited API (one wheel for Python >= 3.11) and the NumPy C-API:
// checks arguments, finds or makes the output, releases the GIL for batches, splits them over threads.
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#define NPY_TARGET_VERSION NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>

#include <cmath>
#include <thread>
#include <vector>

#include "bounded.hpp"
#include "buffers.hpp"
#include "dispatch.hpp"

using namespace kinestatics;

namespace {

constexpr int MAX_DIMENSIONS = 32;
constexpr npy_intp RELEASE_GIL = 64;    // configurations from which on other Python threads may run meanwhile
constexpr npy_intp PER_THREAD = 1024;   // configurations worth a thread of their own
constexpr npy_intp MOST_THREADS = 256;
constexpr int MOST_COLUMNS = 6000;      // 6 * columns^2 * 8 still fits an int
Pool pool;
const Kernels *kernels = nullptr;
thread_local Scratch scratch;

// A program's memory: its joints, and their turns side by side.
struct Joints {
  std::vector<Joint> all;
  std::vector<double> turns;
};
struct Chain {
  PyObject_HEAD
  Program chain, tree;
  Joints *chain_joints, *tree_joints;
};

// kinestatics.errors.<type>(code, message, hint)
PyObject *fail(const char *type, const char *code, PyObject *message, const char *hint) {
  PyObject *module = message ? PyImport_ImportModule("kinestatics.errors") : nullptr;
  PyObject *cls = module ? PyObject_GetAttrString(module, type) : nullptr;
  PyObject *error = cls ? PyObject_CallFunction(cls, "sOs", code, message, hint) : nullptr;
  if (error) PyErr_SetObject(cls, error);
  Py_XDECREF(error), Py_XDECREF(cls), Py_XDECREF(module), Py_XDECREF(message);
  return nullptr;
}
PyObject *shape_text(int nd, const npy_intp *dims) {
  PyObject *tuple = PyTuple_New(nd);
  for (int i = 0; tuple && i < nd; i++) PyTuple_SetItem(tuple, i, PyLong_FromSsize_t(dims[i]));
  return tuple;
}

bool is_ready(PyObject *o) {  // a plain, aligned, C-contiguous float64 array in native byte order
  if (!PyArray_CheckExact(o)) return false;
  PyArrayObject *a = (PyArrayObject *)o;
  return PyArray_TYPE(a) == NPY_DOUBLE && PyArray_ISCARRAY_RO(a);
}
// A new reference to `o` as such an array; everything but the fast path is judged and converted by _kernels/convert.py.
PyArrayObject *as_input(PyObject *o, const char *what) {
  if (is_ready(o)) {
    Py_INCREF(o);
    return (PyArrayObject *)o;
  }
  PyObject *module = PyImport_ImportModule("kinestatics._kernels.convert");
  PyObject *array = module ? PyObject_CallMethod(module, "to_float64", "Os", o, what) : nullptr;
  Py_XDECREF(module);
  return (PyArrayObject *)array;
}
bool is_single_precision(PyObject *o) { return PyArray_Check(o) && PyArray_TYPE((PyArrayObject *)o) == NPY_FLOAT; }

// The name of an argument, and the string object that callers' bytecode shares with us.
struct Word {
  const char *text;
  PyObject *interned;
};
int find(PyObject *word, Word *names, int count) {
  for (int i = 0; i < count; i++)
    if (word == names[i].interned) return i;
  for (int i = 0; i < count; i++)
    if (!PyUnicode_CompareWithASCIIString(word, names[i].text)) {
      if (!names[i].interned && !(names[i].interned = PyUnicode_InternFromString(names[i].text))) PyErr_Clear();
      return i;
    }
  return count;
}
// Arguments by position or keyword into `values` (borrowed), in the order of `names`.
bool parse(const char *method, Word *names, int count, int required, PyObject *const *args, Py_ssize_t given,
           PyObject *keywords, PyObject **values) {
  for (int i = 0; i < count; i++) values[i] = i < given ? args[i] : nullptr;
  if (given > count) {
    PyErr_Format(PyExc_TypeError, "%s() takes %d arguments, %zd were given", method, count, given);
    return false;
  }
  const Py_ssize_t extra = keywords ? PyTuple_Size(keywords) : 0;
  for (Py_ssize_t k = 0; k < extra; k++) {
    PyObject *word = PyTuple_GetItem(keywords, k);
    const int i = find(word, names, count);
    if (i == count || values[i]) {
      PyErr_Format(PyExc_TypeError, "%s() got an unexpected or repeated argument '%U'", method, word);
      return false;
    }
    values[i] = args[given + k];
  }
  for (int i = 0; i < required; i++)
    if (!values[i]) {
      PyErr_Format(PyExc_TypeError, "%s() needs the argument '%s'", method, names[i].text);
      return false;
    }
  for (int i = required; i < count; i++)
    if (values[i] == Py_None) values[i] = nullptr;
  return true;
}

// The leading axes of q; its last axis must be `columns` long.
bool batch_shape(PyArrayObject *q, int columns, const char *what, int &nd, npy_intp &n) {
  nd = PyArray_NDIM(q) - 1;
  if (nd < 0 || nd > MAX_DIMENSIONS - 3 || PyArray_DIM(q, nd) != columns) {
    PyObject *shape = shape_text(PyArray_NDIM(q), PyArray_DIMS(q));
    PyObject *text = shape ? PyUnicode_FromFormat("%s has shape %S; expected (%d,) or (..., %d)", what, shape, columns, columns) : nullptr;
    Py_XDECREF(shape);
    fail("ConfigurationError", "KS303", text, "one entry for each joint, batch axes first");
    return false;
  }
  n = 1;
  for (int i = 0; i < nd; i++) n *= PyArray_DIM(q, i);
  return true;
}
// A second input of `size` entries for each configuration; one for all is repeated.
PyArrayObject *second_input(PyObject *o, const char *what, PyArrayObject *q, int nd, int size) {
  PyArrayObject *a = as_input(o, what);
  if (!a) return nullptr;
  const int found = PyArray_NDIM(a);
  bool same = found == nd + 1 && PyArray_DIM(a, nd) == size;
  for (int i = 0; same && i < nd; i++) same = PyArray_DIM(a, i) == PyArray_DIM(q, i);
  if (same) return a;
  npy_intp dims[MAX_DIMENSIONS];
  for (int i = 0; i < nd; i++) dims[i] = PyArray_DIM(q, i);
  dims[nd] = size;
  if (found == 1 && PyArray_DIM(a, 0) == size) {
    PyArrayObject *repeated = (PyArrayObject *)PyArray_SimpleNew(nd + 1, dims, NPY_DOUBLE);
    if (repeated && PyArray_CopyInto(repeated, a) < 0) Py_CLEAR(repeated);
    Py_DECREF(a);
    return repeated;
  }
  PyObject *shape = shape_text(found, PyArray_DIMS(a)), *expected = shape_text(nd + 1, dims);
  PyObject *text = shape && expected ? PyUnicode_FromFormat("%s has shape %S; expected %S or (%d,)", what, shape, expected, size) : nullptr;
  Py_XDECREF(shape), Py_XDECREF(expected), Py_DECREF(a);
  fail("ConfigurationError", "KS303", text, "one row for each configuration, or one for all");
  return nullptr;
}

struct Lease {
  void *data;
  size_t bytes;
};
void return_lease(PyObject *capsule) {
  Lease *lease = (Lease *)PyCapsule_GetPointer(capsule, "kinestatics.buffer");
  pool.give(lease->data, lease->bytes);
  delete lease;
}
PyObject *new_result(int nd, npy_intp *dims, npy_intp size) {
  const size_t bytes = (size_t)size * sizeof(double);
  if (bytes < Pool::SMALLEST) return PyArray_SimpleNew(nd, dims, NPY_DOUBLE);
  size_t capacity = 0;
  void *data = pool.take(bytes, capacity);
  Lease *lease = data ? new (std::nothrow) Lease{data, capacity} : nullptr;
  if (!lease) {
    std::free(data);
    return PyErr_NoMemory();
  }
  PyObject *capsule = PyCapsule_New(lease, "kinestatics.buffer", return_lease);
  if (!capsule) {
    pool.give(data, capacity);
    delete lease;
    return nullptr;
  }
  PyObject *array = PyArray_New(&PyArray_Type, nd, dims, NPY_DOUBLE, nullptr, data, 0, NPY_ARRAY_CARRAY, nullptr);
  if (!array) {
    Py_DECREF(capsule);
    return nullptr;
  }
  if (PyArray_SetBaseObject((PyArrayObject *)array, capsule) < 0) {  // takes over the capsule
    Py_DECREF(array);
    return nullptr;
  }
  return array;
}
bool overlap(PyArrayObject *a, PyArrayObject *b) {
  const char *pa = PyArray_BYTES(a), *pb = PyArray_BYTES(b);
  return pa < pb + PyArray_NBYTES(b) && pb < pa + PyArray_NBYTES(a);
}
PyObject *check_out(PyObject *out, int nd, npy_intp *dims, PyArrayObject *q, PyArrayObject *second) {
  const char *hint = "out= takes a C-contiguous, writable float64 array of exactly that shape";
  if (!is_ready(out) || !PyArray_ISWRITEABLE((PyArrayObject *)out))
    return fail("ArrayTypeError", "KS304", PyUnicode_FromString("out is not a plain writable float64 array"), hint);
  PyArrayObject *a = (PyArrayObject *)out;
  bool same = PyArray_NDIM(a) == nd;
  for (int i = 0; same && i < nd; i++) same = PyArray_DIM(a, i) == dims[i];
  if (!same) {
    PyObject *found = shape_text(PyArray_NDIM(a), PyArray_DIMS(a)), *expected = shape_text(nd, dims);
    PyObject *text = found && expected ? PyUnicode_FromFormat("out has shape %S; expected %S", found, expected) : nullptr;
    Py_XDECREF(found), Py_XDECREF(expected);
    return fail("ConfigurationError", "KS304", text, hint);
  }
  if (overlap(a, q) || (second && overlap(a, second)))
    return fail("ConfigurationError", "KS305", PyUnicode_FromString("out shares memory with an input"), "give out= an array of its own");
  Py_INCREF(out);
  return out;
}
bool thread_count(PyObject *o, long &threads) {
  threads = 1;
  if (!o) return true;
  threads = PyLong_AsLong(o);
  if (threads == -1 && PyErr_Occurred()) return false;
  if (threads < 1) {
    PyObject *text = PyUnicode_FromFormat("threads is %ld; expected 1 or more", threads);
    fail("ConfigurationError", "KS306", text, "");
    return false;
  }
  return true;
}

// Runs work(first, count, scratch) over all configurations. Parts are whole blocks of 8, so that each configuration meets
// the same instructions however the batch is split.
template <class Work>
bool run(npy_intp n, long threads, size_t scratch_doubles, Work work) {
  npy_intp parts = n / PER_THREAD < threads ? (n / PER_THREAD > 1 ? n / PER_THREAD : 1) : threads;
  if (parts > MOST_THREADS) parts = MOST_THREADS;
  const npy_intp step = ((n + parts - 1) / parts + 7) / 8 * 8;
  bool good = true;
  std::vector<std::thread> others;
  std::vector<char> done;
  auto part = [&](npy_intp i) {
    double *memory = scratch.get(scratch_doubles);
    const npy_intp count = n - i < step ? n - i : step;
    if (memory && count > 0) work(i, count, memory);
    return memory != nullptr;
  };
  if (parts > 1) {
    done.assign(parts, 1);
    for (npy_intp p = 1; p < parts; p++) {
      try {
        others.emplace_back([&, p] { done[p] = part(p * step); });
      } catch (...) {  // no more threads to be had: do it here
        done[p] = part(p * step);
      }
    }
  }
  good = part(0);
  for (std::thread &t : others) t.join();
  for (char d : done) good = good && d;
  return good;
}

// The common course of all methods. `tail` holds the trailing axes of the result.
template <class Work>
PyObject *compute(const Program &program, PyObject *q_object, PyObject *second_object, const char *second_name, int second_size,
                  PyObject *out, PyObject *threads_object, const int *tail, int tail_nd, Work work) {
  PyArrayObject *q = as_input(q_object, "q"), *second = nullptr;
  PyObject *result = nullptr;
  int nd = 0;
  npy_intp n = 0, size = 1, dims[MAX_DIMENSIONS + 4];
  long threads = 1;
  if (!q) return nullptr;
  if (!batch_shape(q, program.columns, "q", nd, n)) goto finish;
  if (second_object && !(second = second_input(second_object, second_name, q, nd, second_size))) goto finish;
  if (!thread_count(threads_object, threads)) goto finish;
  for (int i = 0; i < nd; i++) dims[i] = PyArray_DIM(q, i);
  for (int i = 0; i < tail_nd; i++) dims[nd + i] = tail[i], size *= tail[i];
  result = out ? check_out(out, nd + tail_nd, dims, q, second) : new_result(nd + tail_nd, dims, n * size);
  if (!result || n == 0 || size == 0) goto finish;
  {
    const double *from = (const double *)PyArray_DATA(q), *also = second ? (const double *)PyArray_DATA(second) : nullptr;
    double *to = (double *)PyArray_DATA((PyArrayObject *)result);
    const int columns = program.columns;
    const Kernels *table = kernels;
    auto part = [&](npy_intp first, npy_intp count, double *memory) {
      work(table, from + first * columns, also ? also + first * second_size : nullptr, count, to + first * size, memory);
    };
    const size_t needed = table->scratch_size(&program, tail_nd == 3);
    bool good;
    if (n < RELEASE_GIL) {
      double *memory = scratch.get(needed);
      good = memory != nullptr;
      if (good) part(0, n, memory);
    } else {
      PyThreadState *state = PyEval_SaveThread();
      good = run(n, threads, needed, part);
      PyEval_RestoreThread(state);
    }
    if (!good) {
      Py_CLEAR(result);
      PyErr_NoMemory();
    }
  }
finish:
  Py_DECREF(q);
  Py_XDECREF((PyObject *)second);
  if (result && !out && is_single_precision(q_object)) {  // single precision in, single precision out
    PyObject *rounded = PyArray_Cast((PyArrayObject *)result, NPY_FLOAT);
    Py_DECREF(result);
    return rounded;
  }
  return result;
}

#define KS_METHOD(name) PyObject *name(Chain *self, PyObject *const *args, Py_ssize_t given, PyObject *keywords)
Word PLAIN[] = {{"q", nullptr}, {"out", nullptr}, {"threads", nullptr}};

KS_METHOD(chain_jacobian) {
  PyObject *v[3];
  if (!parse("jacobian", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {6, c->columns};
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], tail, 2,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   if (n > 2) return k->jacobian(c, q, n, out, memory);
                   for (npy_intp i = 0; i < n; i++) k->jacobian_one(c, q + i * c->columns, out + i * 6 * c->columns, memory);
                 });
}
KS_METHOD(chain_pose) {
  PyObject *v[3];
  if (!parse("pose", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {4, 4};
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], tail, 2,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   k->pose(c, q, n, out, memory);
                 });
}
KS_METHOD(chain_jacobian_rate) {
  static Word names[] = {{"q", nullptr}, {"qd", nullptr}, {"out", nullptr}, {"threads", nullptr}};
  PyObject *v[4];
  if (!parse("jacobian_rate", names, 4, 2, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {6, c->columns};
  return compute(*c, v[0], v[1], "qd", c->columns, v[2], v[3], tail, 2,
                 [c](const Kernels *k, const double *q, const double *qd, npy_intp n, double *out, double *memory) {
                   k->jacobian_rate(c, q, qd, n, out, memory);
                 });
}
KS_METHOD(chain_hessian) {
  PyObject *v[3];
  if (!parse("hessian", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {6, c->columns, c->columns};
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], tail, 3,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   k->hessian(c, q, n, out, memory);
                 });
}
KS_METHOD(chain_gravity_torques) {
  PyObject *v[3];
  if (!parse("gravity_torques", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->tree;
  const int tail[] = {c->columns};
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], tail, 1,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   k->gravity_torques(c, q, n, out, memory);
                 });
}
KS_METHOD(chain_joint_torques) {
  static Word names[] = {{"q", nullptr}, {"wrench", nullptr}, {"out", nullptr}, {"threads", nullptr}};
  PyObject *v[4];
  if (!parse("joint_torques", names, 4, 2, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {c->columns};
  return compute(*c, v[0], v[1], "wrench", 6, v[2], v[3], tail, 1,
                 [c](const Kernels *k, const double *q, const double *f, npy_intp n, double *out, double *memory) {
                   k->joint_torques(c, q, f, n, out, memory);
                 });
}
KS_METHOD(chain_manipulability) {
  PyObject *v[3];
  if (!parse("manipulability", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], nullptr, 0,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   k->manipulability(c, q, n, out, memory);
                 });
}
KS_METHOD(chain_singular_values) {
  PyObject *v[3];
  if (!parse("singular_values", PLAIN, 3, 1, args, given, keywords, v)) return nullptr;
  const Program *c = &self->chain;
  const int tail[] = {c->row_count < c->columns ? c->row_count : c->columns};
  return compute(*c, v[0], nullptr, "", 0, v[1], v[2], tail, 1,
                 [c](const Kernels *k, const double *q, const double *, npy_intp n, double *out, double *memory) {
                   k->singular_values(c, q, n, out, memory);
                 });
}
KS_METHOD(chain_damped_rates) {
  static Word names[] = {{"q", nullptr}, {"twist", nullptr}, {"damping", nullptr}, {"out", nullptr}, {"threads", nullptr}};
  PyObject *v[5];
  if (!parse("damped_rates", names, 5, 3, args, given, keywords, v)) return nullptr;
  const double damping = PyFloat_AsDouble(v[2]);
  if (damping == -1.0 && PyErr_Occurred()) return nullptr;
  if (!(damping >= 0) || std::isinf(damping)) {
    PyObject *text = PyUnicode_FromFormat("damping is %S; expected a finite number >= 0", v[2]);
    return fail("ConfigurationError", "KS307", text, "it has the unit of the singular values; 0 gives the plain inverse");
  }
  const Program *c = &self->chain;
  const int tail[] = {c->columns};
  return compute(*c, v[0], v[1], "twist", 6, v[3], v[4], tail, 1,
                 [c, damping](const Kernels *k, const double *q, const double *twist, npy_intp n, double *out, double *memory) {
                   k->damped_rates(c, q, twist, damping, n, out, memory);
                 });
}

// bounded_program(q, twist, settings, program): the arrays of bounded.hpp; False where q or twist need a reader's eye.
PyObject *chain_bounded_program(Chain *self, PyObject *const *args, Py_ssize_t given) {
  const Program *c = &self->chain;
  const int n = c->columns;
  const npy_intp sizes[] = {n, 6, (npy_intp)BoundedSettings::size(n), (npy_intp)BoundedProgram::size(n)};
  if (given != 4) {
    PyErr_Format(PyExc_TypeError, "bounded_program() takes 4 arguments, %zd were given", given);
    return nullptr;
  }
  double *data[4];
  for (int i = 0; i < 4; i++) {
    PyArrayObject *a = (PyArrayObject *)args[i];
    if (!is_ready(args[i]) || PyArray_NDIM(a) != 1 || PyArray_DIM(a, 0) != sizes[i] || (i == 3 && !PyArray_ISWRITEABLE(a)))
      Py_RETURN_FALSE;
    data[i] = (double *)PyArray_DATA(a);
  }
  for (int i = 0; i < n; i++)
    if (!std::isfinite(data[0][i])) Py_RETURN_FALSE;
  double *memory = scratch.get(kernels->scratch_size(c, false));
  if (!memory) return PyErr_NoMemory();
  const BoundedSettings settings(data[2], n);
  BoundedProgram program(data[3], n);
  kernels->jacobian_one(c, data[0], program.J, memory);
  if (!weigh_rows(settings, n, data[1], program)) Py_RETURN_FALSE;
  write_squares(settings, n, program);
  write_bounds(settings, n, data[0], program);
  Py_RETURN_TRUE;
}

// Joints from the bytes of program.py's structured array, checked: an index out of range must never reach the kernels.
Joints *read_joints(const Py_buffer &bytes, int columns) {
  if (bytes.len % (Py_ssize_t)sizeof(Joint)) {
    PyErr_SetString(PyExc_ValueError, "joints: not a whole number of Joint structures");
    return nullptr;
  }
  const size_t count = bytes.len / sizeof(Joint);
  const size_t padded = (count + 7) / 8 * 8;
  auto *joints = new Joints{std::vector<Joint>(count), std::vector<double>(3 * padded)};
  if (count) std::memcpy(joints->all.data(), bytes.buf, bytes.len);
  for (size_t i = 0; i < count; i++) {
    Joint &j = joints->all[i];
    j.plain = j.kind == REVOLUTE && j.scale == 1.0 && !j.add;
    j.rounder = ROUND_TO_WHOLE + j.quarter;
    joints->turns[i] = j.kind == PRISMATIC ? 0 : j.scale;
    joints->turns[padded + i] = j.kind == PRISMATIC ? 0 : j.offset;
    joints->turns[2 * padded + i] = j.rounder;
    if (j.column < 0 || j.column >= columns || j.parent >= (int)i || j.parent < -1 || j.kind < 0 || j.kind > HELICAL) {
      delete joints;
      PyErr_SetString(PyExc_ValueError, "joints: index out of range");
      return nullptr;
    }
  }
  return joints;
}
void finish_program(Program &p, const Joints &memory) {
  const std::vector<Joint> &joints = memory.all;
  const double *turns = memory.turns.data();
  const size_t padded = memory.turns.size() / 3;
  p.joints = (int)joints.size();
  p.joint = joints.data();
  p.turns = {turns, turns + padded, turns + 2 * padded, true};
  p.slides = false;
  for (size_t i = 0; i < joints.size(); i++) {
    if (joints[i].column != (int)i) p.turns.in_order = false;
    if (joints[i].kind == PRISMATIC) p.slides = true;
  }
  std::vector<char> used(p.columns, 0);
  p.vertical = false;
  for (const Joint &j : joints) {
    used[j.column] = 1;
    if (j.kind != REVOLUTE) p.vertical = true;
  }
  p.all_columns = true;
  for (char u : used) p.all_columns = p.all_columns && u;
}

int chain_init(Chain *self, PyObject *args, PyObject *) {
  Py_buffer chain, tree, tail, rows;
  int columns, origin_at_base, axes_of_target, rank;
  double gravity;
  if (!PyArg_ParseTuple(args, "y*y*ippy*dy*i", &chain, &tree, &columns, &origin_at_base, &axes_of_target, &tail, &gravity, &rows, &rank))
    return -1;
  int status = -1;
  Joints *chain_joints = nullptr, *tree_joints = nullptr;
  const int row_count = (int)(rows.len / sizeof(int));
  bool good = columns >= 0 && columns <= MOST_COLUMNS && tail.len == 12 * sizeof(double);
  good = good && rows.len % sizeof(int) == 0 && row_count <= 6 && rank >= 0 && rank <= row_count && rank <= columns;
  for (int i = 0; good && i < row_count; i++) good = ((const int *)rows.buf)[i] >= 0 && ((const int *)rows.buf)[i] < 6;
  if (self->chain_joints) {  // a running call may hold the old program
    PyErr_SetString(PyExc_TypeError, "a Chain is made once");
  } else if (!good) {
    PyErr_SetString(PyExc_ValueError, "Chain: sizes do not fit");
  } else if ((chain_joints = read_joints(chain, columns)) && (tree_joints = read_joints(tree, columns))) {
    self->chain_joints = chain_joints, self->tree_joints = tree_joints;
    Program p{};
    p.columns = columns, p.gravity = gravity, p.row_count = row_count, p.rank = rank;
    p.origin_at_base = origin_at_base != 0, p.axes_of_target = axes_of_target != 0;
    std::memcpy(p.tail_rotation, tail.buf, 9 * sizeof(double));
    std::memcpy(p.tail_position, (const double *)tail.buf + 9, 3 * sizeof(double));
    if (row_count) std::memcpy(p.rows, rows.buf, rows.len);
    self->chain = self->tree = p;
    finish_program(self->chain, *chain_joints);
    finish_program(self->tree, *tree_joints);
    status = 0;
  } else {
    delete chain_joints;
  }
  PyBuffer_Release(&chain), PyBuffer_Release(&tree), PyBuffer_Release(&tail), PyBuffer_Release(&rows);
  return status;
}
void chain_dealloc(Chain *self) {
  PyTypeObject *type = Py_TYPE((PyObject *)self);
  delete self->chain_joints;
  delete self->tree_joints;
  ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
  Py_DECREF(type);
}

// ---- the module -------------------------------------------------------------------------------------------------------
PyObject *instruction_set(PyObject *, PyObject *) { return PyUnicode_FromString(kernels->name); }
PyObject *instruction_sets(PyObject *, PyObject *) {
  PyObject *list = PyList_New(0);
  for (const char *name : {"avx512", "avx2", "baseline"})
    if (list && find_kernels(name)) {
      PyObject *text = PyUnicode_FromString(name);
      if (!text || PyList_Append(list, text) < 0) Py_CLEAR(list);
      Py_XDECREF(text);
    }
  return list;
}
PyObject *select_instruction_set(PyObject *, PyObject *name) {
  PyObject *bytes = PyUnicode_AsUTF8String(name);
  if (!bytes) return nullptr;
  const Kernels *found = find_kernels(PyBytes_AsString(bytes));
  Py_DECREF(bytes);
  if (!found) {
    PyErr_Format(PyExc_ValueError, "this processor has no instruction set %R", name);
    return nullptr;
  }
  kernels = found;
  Py_RETURN_NONE;
}
PyObject *release_memory(PyObject *, PyObject *) {
  pool.clear();
  Py_RETURN_NONE;
}
// Largest |x| of a plain float64 array, NaN if it holds one; None for everything else.
PyObject *largest(PyObject *, PyObject *o) {
  if (!is_ready(o)) Py_RETURN_NONE;
  const double *x = (const double *)PyArray_DATA((PyArrayObject *)o);
  const npy_intp n = PyArray_SIZE((PyArrayObject *)o);
  double most = 0, poison = 0;
  for (npy_intp i = 0; i < n; i++) {
    const double a = std::fabs(x[i]);
    most = a > most ? a : most;
    poison += a - a;  // 0, or NaN from NaN and infinity
  }
  return PyFloat_FromDouble(poison == 0 ? most : poison);
}
PyObject *sincos_for_tests(PyObject *, PyObject *o) {
  PyArrayObject *x = as_input(o, "x");
  if (!x) return nullptr;
  PyObject *s = PyArray_SimpleNew(PyArray_NDIM(x), PyArray_DIMS(x), NPY_DOUBLE);
  PyObject *c = PyArray_SimpleNew(PyArray_NDIM(x), PyArray_DIMS(x), NPY_DOUBLE);
  if (s && c)
    kernels->sincos((const double *)PyArray_DATA(x), PyArray_SIZE(x), (double *)PyArray_DATA((PyArrayObject *)s),
                    (double *)PyArray_DATA((PyArrayObject *)c));
  Py_DECREF(x);
  PyObject *pair = s && c ? PyTuple_Pack(2, s, c) : nullptr;
  Py_XDECREF(s), Py_XDECREF(c);
  return pair;
}

#define KS_ENTRY(name, text) {#name, (PyCFunction)(void *)chain_##name, METH_FASTCALL | METH_KEYWORDS, text}
#define KS_COMMON "\n\nout: the result's array, float64 and C-contiguous; threads: how many share a large batch.\n" \
                  "Raises ArrayTypeError KS302, KS304 and ConfigurationError KS303-KS306."
PyMethodDef chain_methods[] = {
    KS_ENTRY(jacobian, "jacobian(q, out=None, threads=None)\n\nq (..., n) -> J (..., 6, n) in the frame of this object." KS_COMMON),
    KS_ENTRY(pose, "pose(q, out=None, threads=None)\n\nq (..., n) -> (..., 4, 4): axes and point of the target seen from the base [m]." KS_COMMON),
    KS_ENTRY(jacobian_rate, "jacobian_rate(q, qd, out=None, threads=None)\n\nq, qd (..., n) -> d/dt of the matrix that jacobian returns, (..., 6, n)." KS_COMMON),
    KS_ENTRY(hessian, "hessian(q, out=None, threads=None)\n\nq (..., n) -> H[..., r, j, k] = dJ[r, j]/dq_k, (..., 6, n, n)." KS_COMMON),
    KS_ENTRY(gravity_torques, "gravity_torques(q, out=None, threads=None)\n\nq (..., n) -> what holds the arm against gravity, (..., n) [N m, N]." KS_COMMON),
    KS_ENTRY(joint_torques, "joint_torques(q, wrench, out=None, threads=None)\n\nJ^T w for bare six-vectors w (..., 6) in the frame of this object: what holds a wrench that\n"
                            "the robot exerts on its surroundings; a load on the robot has the opposite sign." KS_COMMON),
    KS_ENTRY(manipulability, "manipulability(q, out=None, threads=None)\n\nq (..., n) -> product of the singular values of the rows in play that the arm can have, (...)." KS_COMMON),
    KS_ENTRY(singular_values, "singular_values(q, out=None, threads=None)\n\nq (..., n) -> those of the rows in play, descending, (..., min(rows, n))." KS_COMMON),
    KS_ENTRY(damped_rates, "damped_rates(q, twist, damping, out=None, threads=None)\n\nJ^T (J J^T + damping^2 I)^-1 twist over the rows in play, (..., n). The normal equations lose what\n"
                           "lies below 1e-8 of the largest singular value: keep damping above 1e-7 of it near singularities." KS_COMMON),
    {"bounded_program", (PyCFunction)(void *)chain_bounded_program, METH_FASTCALL,
     "bounded_program(q, twist, settings, program, /)\n\nWrites the quadratic program of one period of a control loop into `program`; the layouts are those of\n"
     "bounded.hpp. False where an array is not plain, not of its size, or q or the twist is not finite (NaN: free)."},
    {nullptr, nullptr, 0, nullptr}};
PyType_Slot chain_slots[] = {{Py_tp_methods, chain_methods},
                             {Py_tp_init, (void *)chain_init},
                             {Py_tp_new, (void *)PyType_GenericNew},
                             {Py_tp_dealloc, (void *)chain_dealloc},
                             {0, nullptr}};
PyType_Spec chain_spec = {"kinestatics._kernels._core.Chain", (int)sizeof(Chain), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE,
                          chain_slots};
PyMethodDef module_methods[] = {{"instruction_set", instruction_set, METH_NOARGS, nullptr},
                                {"instruction_sets", instruction_sets, METH_NOARGS, nullptr},
                                {"select_instruction_set", select_instruction_set, METH_O, nullptr},
                                {"release_memory", release_memory, METH_NOARGS, nullptr},
                                {"largest", largest, METH_O, nullptr},
                                {"sincos", sincos_for_tests, METH_O, nullptr},
                                {nullptr, nullptr, 0, nullptr}};
PyModuleDef module = {PyModuleDef_HEAD_INIT, "_core", nullptr, -1, module_methods, nullptr, nullptr, nullptr, nullptr};

}  // namespace

PyMODINIT_FUNC PyInit__core() {
  import_array();
  kernels = find_kernels(nullptr);
  PyObject *m = PyModule_Create(&module);
  PyObject *type = m ? PyType_FromSpec(&chain_spec) : nullptr;
  if (!type || PyModule_AddObjectRef(m, "Chain", type) < 0 || PyModule_AddIntConstant(m, "JOINT_SIZE", sizeof(Joint)) < 0) {
    Py_XDECREF(type), Py_XDECREF(m);
    return nullptr;
  }
  Py_DECREF(type);
  return m;
}
