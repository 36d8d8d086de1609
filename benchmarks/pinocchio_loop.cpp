// The C++ peer: Pinocchio called in a plain loop over configurations, row-major output. The model is built joint by joint
// from numbers (pinocchio_cpp.py), so that no parser has to be linked. Compile with -DNDEBUG: assertions cost 1.6 times.
#include <pinocchio/multibody.hpp>

#include <Eigen/Dense>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics-derivatives.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

using namespace pinocchio;
typedef Eigen::Map<const Eigen::VectorXd> Vector;
typedef Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor> Rows;
typedef Eigen::Matrix<double, 4, 4, Eigen::RowMajor> Pose;

struct Loop {
  Model model;
  Data *data = nullptr;
  FrameIndex tool;
  JointIndex joint;
};
static SE3 placement(const double *m) {
  SE3::Matrix3 R;
  for (int r = 0; r < 3; r++)
    for (int k = 0; k < 3; k++) R(r, k) = m[4 * r + k];
  return SE3(R, SE3::Vector3(m[3], m[7], m[11]));
}

extern "C" {
// For each joint: parent, axis 'X' 'Y' 'Z' (revolute), placement (4x4), mass, lever (3), inertia (3x3).
void *loop_new(int n, const int *parents, const char *axes, const double *placements, const double *masses, const double *levers,
               const double *inertias, int tool_parent, const double *tool_placement) {
  Loop *h = new Loop;
  for (int i = 0; i < n; i++) {
    const SE3 M = placement(placements + 16 * i);
    const std::string name = "joint" + std::to_string(i);
    const JointIndex id = axes[i] == 'X'   ? h->model.addJoint(parents[i], JointModelRX(), M, name)
                          : axes[i] == 'Y' ? h->model.addJoint(parents[i], JointModelRY(), M, name)
                                           : h->model.addJoint(parents[i], JointModelRZ(), M, name);
    Eigen::Matrix3d I;
    for (int k = 0; k < 9; k++) I(k / 3, k % 3) = inertias[9 * i + k];
    const Eigen::Vector3d lever(levers[3 * i], levers[3 * i + 1], levers[3 * i + 2]);
    h->model.appendBodyToJoint(id, Inertia(masses[i], lever, I), SE3::Identity());
  }
  h->joint = tool_parent;
  h->tool = h->model.addFrame(Frame("tool", tool_parent, 0, placement(tool_placement), OP_FRAME));
  h->data = new Data(h->model);
  return h;
}
void loop_jacobian(void *p, const double *q, const double *, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  Data::Matrix6x J(6, n);
  for (long i = 0; i < count; i++) {
    J.setZero();
    computeFrameJacobian(h->model, *h->data, Vector(q + i * n, n), h->tool, LOCAL_WORLD_ALIGNED, J);
    Eigen::Map<Rows>(out + i * 6 * n, 6, n) = J;
  }
}
void loop_pose(void *p, const double *q, const double *, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  for (long i = 0; i < count; i++) {
    forwardKinematics(h->model, *h->data, Vector(q + i * n, n));
    Eigen::Map<Pose>(out + i * 16) = updateFramePlacement(h->model, *h->data, h->tool).toHomogeneousMatrix();
  }
}
void loop_gravity(void *p, const double *q, const double *, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  for (long i = 0; i < count; i++)
    Eigen::Map<Eigen::VectorXd>(out + i * n, n) = computeGeneralizedGravity(h->model, *h->data, Vector(q + i * n, n));
}
void loop_rate(void *p, const double *q, const double *qd, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  Data::Matrix6x J(6, n);
  for (long i = 0; i < count; i++) {
    J.setZero();
    computeJointJacobiansTimeVariation(h->model, *h->data, Vector(q + i * n, n), Vector(qd + i * n, n));
    updateFramePlacement(h->model, *h->data, h->tool);
    getFrameJacobianTimeVariation(h->model, *h->data, h->tool, LOCAL_WORLD_ALIGNED, J);
    Eigen::Map<Rows>(out + i * 6 * n, 6, n) = J;
  }
}
// Pinocchio has the Hessian of a joint frame, not of a tool behind it.
void loop_hessian(void *p, const double *q, const double *, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  Data::Tensor3x H(6, n, n);
  for (long i = 0; i < count; i++) {
    computeJointKinematicHessians(h->model, *h->data, Vector(q + i * n, n));
    H.setZero();
    getJointKinematicHessian(h->model, *h->data, h->joint, LOCAL_WORLD_ALIGNED, H);
    std::memcpy(out + i * 6 * n * n, H.data(), sizeof(double) * 6 * n * n);
  }
}
void loop_manipulability(void *p, const double *q, const double *, long count, double *out) {
  Loop *h = (Loop *)p;
  const int n = h->model.nv;
  Data::Matrix6x J(6, n);
  for (long i = 0; i < count; i++) {
    J.setZero();
    computeFrameJacobian(h->model, *h->data, Vector(q + i * n, n), h->tool, LOCAL_WORLD_ALIGNED, J);
    Eigen::Matrix<double, 6, 6> A;
    A.noalias() = J * J.transpose();
    out[i] = A.llt().matrixL().determinant();
  }
}
}
