// A robot as the kernels see it, filled by program.py: plain data, the same for every instruction set.
#pragma once
#include <cstddef>
#include <cstdint>

namespace kinestatics {

// How the fixed rotation before a joint is applied: Rx(alpha) by kind of alpha, or a full matrix.
enum Turn : int { TURN_NONE = 0, TURN_PLUS_90 = 1, TURN_MINUS_90 = 2, TURN_GENERAL = 3, TURN_MATRIX = 4 };
enum Kind : int { REVOLUTE = 0, PRISMATIC = 1, HELICAL = 2 };

// Adding 1.5 * 2^52 rounds a double to a whole number, which then stands in its low bits.
static constexpr double ROUND_TO_WHOLE = 6755399441055744.0;

// A joint in canonical form. Its axis is z. Seen from the frame behind the joint before, the fixed part is a translation
// p and then a turn; then the joint turns about z by scale * q + offset + quarter * 90 degrees and moves along z by
// lift * q + lift0 (a prismatic joint turns by the constant cosine, sine instead).
struct Joint {
  int turn, shift_mask, kind, quarter;
  int column, parent;
  int add;       // an earlier joint of the program has this column too
  int branches;  // some later joint starts here although another joint comes between
  int plain;     // revolute, scale 1, the only joint of its column; filled by the binding
  double ca, sa, p[3];
  double scale, offset, lift, lift0, cosine, sine;
  double matrix[9];
  double mass, subtree_mass, moment[3];  // moment: mass * centre of mass in the frame behind the joint
  double rounder;                        // ROUND_TO_WHOLE + quarter; filled by the binding
};

// The same numbers of all joints side by side, for one configuration at a time; padded to a whole number of vectors.
struct Turns {
  const double *scale, *offset, *rounder;  // a prismatic joint has scale 0
  bool in_order;                           // joint i belongs to column i
};

// Where the columns are written: at the target's point or at the base origin; in base axes or in the target's.
struct Program {
  int joints, columns;
  bool origin_at_base, axes_of_target, all_columns;
  double tail_rotation[9], tail_position[3];  // the target seen from the frame behind the last joint
  double gravity;                             // the tree program's base is turned so that gravity points along -z
  bool vertical;                              // some joint of the tree program moves along its axis
  int row_count, rows[6];                     // rows in play for manipulability, singular values and damped rates
  int rank;                                   // what the arm can have in these rows
  bool slides;                                // some joint is prismatic
  const Joint *joint;
  Turns turns;
};

// One table of entry points for each instruction set. `scratch` is 64-byte aligned; scratch_size() tells how many doubles
// it holds, for the Hessian or for all else.
struct Kernels {
  const char *name;
  size_t (*scratch_size)(const Program *, bool hessian);
  void (*pose)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*jacobian)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*jacobian_one)(const Program *, const double *q, double *out, double *scratch);
  void (*jacobian_rate)(const Program *, const double *q, const double *qd, ptrdiff_t n, double *out, double *scratch);
  void (*hessian)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*gravity_torques)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*joint_torques)(const Program *, const double *q, const double *wrench, ptrdiff_t n, double *out, double *scratch);
  void (*manipulability)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*singular_values)(const Program *, const double *q, ptrdiff_t n, double *out, double *scratch);
  void (*damped_rates)(const Program *, const double *q, const double *twist, double damping, ptrdiff_t n, double *out,
                       double *scratch);
  void (*sincos)(const double *x, ptrdiff_t n, double *sine, double *cosine);
};

}  // namespace kinestatics
