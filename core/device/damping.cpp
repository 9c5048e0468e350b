#include "core/device/damping.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

// relative tolerance of the symmetry check
constexpr double kAsymmetry = 1e-9;

[[noreturn]] void refuse(const std::string& message) { throw std::invalid_argument(message); }

}  // namespace

double Damping::least() const {
  switch (kind_) {
    case Kind::isotropic:
      return matrix_(0, 0);
    case Kind::axes:
      return matrix_.diagonal().minCoeff();
    case Kind::matrix:
      break;
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(matrix_, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

Vec3 Damping::per_axis() const {
  return kind_ == Kind::matrix ? Vec3(Vec3::Constant(least())) : Vec3(matrix_.diagonal());
}

void validate(const Damping& damping, const char* field) {
  const Mat3& m = damping.matrix();
  const std::string name(field);
  if (!m.allFinite()) refuse(name + " must be finite");
  if (damping.kind() != Damping::Kind::matrix) {
    if (!(m.diagonal().minCoeff() >= 0.0)) refuse(name + " must not be negative");
    return;
  }
  const double largest = m.cwiseAbs().maxCoeff();
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > kAsymmetry * largest)
    refuse(name + " matrix must be symmetric; give xy = yx, xz = zx, yz = zy");
  if (!(damping.least() > 0.0)) {
    std::ostringstream text;
    text << name << " matrix must be positive definite, its smallest eigenvalue is "
         << damping.least() << "; it must be above zero in every direction";
    refuse(text.str());
  }
}

}  // namespace feltwire
