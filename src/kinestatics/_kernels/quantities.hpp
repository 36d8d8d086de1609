// Jacobian, pose, rate, Hessian, gravity torques and J^T f, batched. Each is a function of one block of LANES
// configurations, given to `sweep`, which walks over the batch.
#pragma once
#include "chain.hpp"

namespace {  // every instruction set has its own copy: nothing here may be shared by the linker


// Outputs larger than this leave the caches anyway and are written past them.
static constexpr ptrdiff_t STREAM_BYTES = 3 << 18;

// One row-wise input: `size` doubles for each configuration.
struct Input {
  const double *data;
  int size;
  V *lanes;
};
KS_INLINE void read_input(const Input &in, ptrdiff_t i, ptrdiff_t n) {
  read_rows(in.data + i * in.size, in.size, (n - i) * in.size, in.lanes);
}
// The last, incomplete block: missing configurations repeat the last one.
KS_INLINE void read_last(const Input &in, ptrdiff_t i, ptrdiff_t n) {
  for (int e = 0; e < in.size; e++) {
    double lane[LANES];
    for (int w = 0; w < LANES; w++) lane[w] = in.data[(i + w < n ? i + w : n - 1) * in.size + e];
    in.lanes[e] = load(lane);
  }
}
static inline size_t line_buffer_at(const Program &c, bool hessian) { return (block_size(c, hessian) + 63) / 64 * 64; }
static inline size_t sweep_size(const Program &c, bool hessian) {
  return line_buffer_at(c, hessian) + 2 * LineWriter::half(entries_size(c, hessian));
}
KS_INLINE double *line_buffer(const Program &c, double *scratch, bool hessian = false) {
  return scratch + line_buffer_at(c, hessian);
}

template <class Compute>
KS_INLINE void sweep(const Input *inputs, int count, ptrdiff_t n, const V *entries, int size, double *out, double *buffer,
                     Compute compute) {
  ptrdiff_t i = 0;
  if (n * size * (ptrdiff_t)sizeof(double) >= STREAM_BYTES) {
    LineWriter lines(out, buffer, size);
    for (; i + LANES <= n; i += LANES) {
      for (int k = 0; k < count; k++) read_input(inputs[k], i, n);
      compute();
      lines.put(entries, size);
    }
    lines.finish();
  } else {
    for (; i + LANES <= n; i += LANES) {
      for (int k = 0; k < count; k++) read_input(inputs[k], i, n);
      compute();
      write_rows(entries, size, out + i * size);
    }
  }
  if (i < n) {
    for (int k = 0; k < count; k++) read_last(inputs[k], i, n);
    compute();
    write_rows(entries, size, buffer);
    std::memcpy(out + i * size, buffer, sizeof(double) * size * (n - i));
  }
}
KS_INLINE void clear(V *entries, int size) {
  for (int e = 0; e < size; e++) entries[e] = broadcast(0);
}

static void k_jacobian(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  if (!c.all_columns) clear(b.entries, 6 * c.columns);  // columns off the path stay zero
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, b.entries, 6 * c.columns, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
  });
}
static void k_pose(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  V *T = b.entries;
  clear(T, 15);
  T[15] = broadcast(1);
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, T, 16, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    const Frame f = tail(c, forward<false>(c, b.q, b));
    T[0] = f.X.x, T[1] = f.Y.x, T[2] = f.Z.x, T[3] = f.p.x;
    T[4] = f.X.y, T[5] = f.Y.y, T[6] = f.Z.y, T[7] = f.p.y;
    T[8] = f.X.z, T[9] = f.Y.z, T[10] = f.Z.z, T[11] = f.p.z;
  });
}

// Rates of all columns, d/dt of what jacobian_block writes. A joint's axis turns with the body before it; with w and vo
// the angular velocity and the velocity of the point p: d/dt (z x (at - p)) = (w x z) x (at - p) + z x (v_at - vo).
KS_INLINE void rate_block(const Program &c, Block &b) {
  const Frame f = forward(c, b.q, b);
  const V zero = broadcast(0);
  const Vec none{zero, zero, zero};
  const Vec target = tail_point(c, f);
  Vec w = none, vo = none;
  for (int i = 0; i < c.joints; i++) {  // b.w: w x z of each axis; b.v: velocity of each joint's origin
    const Joint &j = c.joint[i];
    if (i) vo = vo + cross(w, b.at[i].origin - b.at[i - 1].origin);
    else vo = none;
    b.at[i].w = cross(w, b.at[i].axis);
    const V rate = b.second[j.column];
    if (j.kind != kinestatics::REVOLUTE) vo = add_scaled(vo, j.lift * rate, b.at[i].axis);
    b.at[i].v = vo;
    if (j.kind != kinestatics::PRISMATIC) w = add_scaled(w, j.scale * rate, b.at[i].axis);
  }
  if (c.joints) vo = vo + cross(w, target - b.at[c.joints - 1].origin);
  const Vec at = c.origin_at_base ? none : target, v_at = c.origin_at_base ? none : vo;
  const Frame t = c.axes_of_target ? tail(c, f) : f;
  for (int i = 0; i < c.joints; i++) {
    const Joint &j = c.joint[i];
    Vec dv = scaled(b.at[i].w, j.lift), dw = none;
    if (j.kind != kinestatics::PRISMATIC) {
      Vec turned = cross(b.at[i].w, at - b.at[i].origin) + cross(b.at[i].axis, v_at - b.at[i].v);
      dw = scaled(b.at[i].w, j.scale);
      dv = j.kind == kinestatics::HELICAL ? add_scaled(scaled(turned, j.scale), j.lift, b.at[i].w) : scaled(turned, j.scale);
    }
    if (c.axes_of_target) {
      Vec v, u;
      twist_of(j, b.at[i].axis, b.at[i].origin, at, v, u);
      dv = into_axes(t, dv - cross(w, v));
      dw = into_axes(t, dw - cross(w, u));
    }
    put(b.entries, c.columns, j, dv, dw);
  }
}
static void k_jacobian_rate(const Program *cp, const double *q, const double *qd, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  if (!c.all_columns) clear(b.entries, 6 * c.columns);
  const Input in[] = {{q, c.columns, b.q}, {qd, c.columns, b.second}};
  sweep(in, 2, n, b.entries, 6 * c.columns, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    rate_block(c, b);
  });
}

// H[r][j][k] = dJ[r][j] / dq_k. With k before or at j on the chain, everything behind k turns with it: dX_j = w_k x X_j at a
// point carried along; when j is before k only the point moves, by v_k. At the fixed base origin only the bracket remains.
KS_INLINE void put_second(V *H, int n, const Joint &j, const Joint &k, Vec dv, Vec dw) {
  V *e = H + j.column * n + k.column;
  const int plane = n * n;
  const V six[6] = {dv.x, dv.y, dv.z, dw.x, dw.y, dw.z};
  if (__builtin_expect(j.add | k.add, 0)) {
    for (int r = 0; r < 6; r++) e[r * plane] += six[r];
  } else {
    KS_UNROLL
    for (int r = 0; r < 6; r++) e[r * plane] = six[r];
  }
}
KS_INLINE void hessian_block(const Program &c, Block &b) {
  const Frame f = forward(c, b.q, b);
  const V zero = broadcast(0);
  const Vec none{zero, zero, zero};
  const Vec at = c.origin_at_base ? none : tail_point(c, f);
  for (int i = 0; i < c.joints; i++) twist_of(c.joint[i], b.at[i].axis, b.at[i].origin, at, b.at[i].v, b.at[i].w);
  const Frame t = c.axes_of_target ? tail(c, f) : f;
  for (int k = 0; k < c.joints; k++)
    for (int j = k; j < c.joints; j++) {
      const Joint &jj = c.joint[j], &jk = c.joint[k];
      Vec late = cross(b.at[k].w, b.at[j].v), late_w = cross(b.at[k].w, b.at[j].w);  // column j, moved by the earlier joint k
      Vec early = late, early_w = none;                                  // column k, moved by the later joint j
      if (c.origin_at_base) late = late - cross(b.at[j].w, b.at[k].v), early = none;
      if (c.axes_of_target) {
        late = into_axes(t, late - cross(b.at[k].w, b.at[j].v)), late_w = into_axes(t, late_w - cross(b.at[k].w, b.at[j].w));
        early = into_axes(t, early - cross(b.at[j].w, b.at[k].v)), early_w = into_axes(t, early_w - cross(b.at[j].w, b.at[k].w));
      }
      put_second(b.entries, c.columns, jj, jk, late, late_w);
      if (j > k) put_second(b.entries, c.columns, jk, jj, early, early_w);
    }
}
static void k_hessian(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  clear(b.entries, 6 * c.columns * c.columns);
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, b.entries, 6 * c.columns * c.columns, out, line_buffer(c, scratch, true), [&]() __attribute__((always_inline)) {
    hessian_block(c, b);
  });
}

// Torques that hold a tree of bodies against gravity, which points along -z of the program's base. One sweep out for the
// first moments of mass, one sweep in to add them up behind each joint: O(joints).
// Where no joint moves along its axis the third row of the frames is not needed, and never computed if never stored.
struct Saved {
  V x[4], y[4], z[4];
  template <bool VERTICAL>
  KS_INLINE_METHOD void keep(const Frame &f) {
    x[0] = f.X.x, x[1] = f.Y.x, x[2] = f.Z.x, x[3] = f.p.x;
    y[0] = f.X.y, y[1] = f.Y.y, y[2] = f.Z.y, y[3] = f.p.y;
    if (VERTICAL) z[0] = f.X.z, z[1] = f.Y.z, z[2] = f.Z.z, z[3] = f.p.z;
  }
  template <bool VERTICAL>
  KS_INLINE_METHOD Frame frame() const {
    if (!VERTICAL) {
      const V none = broadcast(0);
      return {{x[0], y[0], none}, {x[1], y[1], none}, {x[2], y[2], none}, {x[3], y[3], none}};
    }
    return {{x[0], y[0], z[0]}, {x[1], y[1], z[1]}, {x[2], y[2], z[2]}, {x[3], y[3], z[3]}};
  }
};
template <bool VERTICAL>
KS_INLINE void gravity_block(const Program &c, Block &b, Saved *saved) {
  all_sines(c, b.q, b.at);
  Frame f = base_frame();
  for (int i = 0; i < c.joints; i++) {
    const Joint &j = c.joint[i];
    if (j.parent != i - 1 || j.parent < 0) f = j.parent < 0 ? base_frame() : saved[j.parent].frame<VERTICAL>();
    step_fixed(j, f);
    step_moving(j, b.at[i].sine, b.at[i].cosine, b.q[j.column], f);
    if (j.branches) saved[i].keep<VERTICAL>(f);  // a branch starts here again later
    b.at[i].axis.x = f.Z.x, b.at[i].axis.y = f.Z.y, b.at[i].origin.x = f.p.x, b.at[i].origin.y = f.p.y;
    if (VERTICAL) b.at[i].axis.z = f.Z.z;
    const V m = broadcast(j.mass);
    b.at[i].v.x = fma_(j.moment[2], f.Z.x, fma_(j.moment[1], f.Y.x, fma_(j.moment[0], f.X.x, m * f.p.x)));
    b.at[i].v.y = fma_(j.moment[2], f.Z.y, fma_(j.moment[1], f.Y.y, fma_(j.moment[0], f.X.y, m * f.p.y)));
  }
  for (int k = 0; k < c.columns; k++) b.entries[k] = broadcast(0);
  for (int i = c.joints - 1; i >= 0; i--) {
    const Joint &j = c.joint[i];
    const Vec &axis = b.at[i].axis, &origin = b.at[i].origin, &moment = b.at[i].v;
    if (j.parent >= 0) b.at[j.parent].v.x += moment.x, b.at[j.parent].v.y += moment.y;
    V torque = broadcast(0);
    const V m = broadcast(j.subtree_mass);
    if (!VERTICAL || j.kind != kinestatics::PRISMATIC)
      torque = j.scale * (axis.x * fnma_(m, origin.y, moment.y) - axis.y * fnma_(m, origin.x, moment.x));
    if (VERTICAL && j.kind != kinestatics::REVOLUTE) torque = fma_(j.lift * m, axis.z, torque);
    b.entries[j.column] += c.gravity * torque;
  }
}
static void k_gravity_torques(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  Saved *saved = (Saved *)(scratch + sweep_size(c, false));
  const Input in[] = {{q, c.columns, b.q}};
  double *buffer = line_buffer(c, scratch);
  if (c.vertical)
    sweep(in, 1, n, b.entries, c.columns, out, buffer, [&]() __attribute__((always_inline)) { gravity_block<true>(c, b, saved); });
  else
    sweep(in, 1, n, b.entries, c.columns, out, buffer, [&]() __attribute__((always_inline)) { gravity_block<false>(c, b, saved); });
}
static void k_joint_torques(const Program *cp, const double *q, const double *wrench, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  V *J = b.entries, *torque = b.result;
  clear(J, 6 * c.columns);
  V f[8];
  const Input in[] = {{q, c.columns, b.q}, {wrench, 6, f}};
  sweep(in, 2, n, torque, c.columns, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
    for (int k = 0; k < c.columns; k++) {
      V sum = J[k] * f[0];
      KS_UNROLL
      for (int r = 1; r < 6; r++) sum = fma_(J[r * c.columns + k], f[r], sum);
      torque[k] = sum;
    }
  });
}
static size_t k_scratch_size(const Program *cp, bool hessian) {
  const Program &c = *cp;
  return sweep_size(c, hessian) + (size_t)c.joints * sizeof(Saved) / sizeof(double);
}

}  // namespace
