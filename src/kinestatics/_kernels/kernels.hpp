// All kernels of one instruction set as a table; included once by each isa_*.cpp with its own LANES.
#pragma once
#include "factor.hpp"
#include "single.hpp"

namespace {

static void k_jacobian_single(const Program *c, const double *q, double *out, double *scratch) {
  if (c->axes_of_target) k_jacobian(c, q, 1, out, scratch);  // needs the whole target frame: one lane of a block
  else k_jacobian_one(c, q, out, scratch);
}
static void k_sincos(const double *x, ptrdiff_t n, double *sine, double *cosine) {
  double from[LANES], s[LANES], c[LANES];
  for (ptrdiff_t i = 0; i < n; i += LANES) {
    for (int w = 0; w < LANES; w++) from[w] = x[i + w < n ? i + w : n - 1];
    V vs, vc;
    sincos(load(from), 0, vs, vc);
    store(s, vs), store(c, vc);
    for (int w = 0; w < LANES && i + w < n; w++) sine[i + w] = s[w], cosine[i + w] = c[w];
  }
}
static constexpr kinestatics::Kernels table(const char *name) {
  return {name,          k_scratch_size,   k_pose,           k_jacobian,        k_jacobian_single, k_jacobian_rate, k_hessian,
          k_gravity_torques, k_joint_torques, k_manipulability, k_singular_values, k_damped_rates,    k_sincos};
}

}  // namespace
