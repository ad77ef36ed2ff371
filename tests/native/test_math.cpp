// Order statistics, small matrices and rotations beside Eigen's and the C++ library's.
#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "math/matrix.hpp"
#include "math/order.hpp"
#include "math/so3.hpp"
#include "plain.hpp"

using namespace rvdnav;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

namespace {

Matrix random_matrix(plain::Random& random, int rows, int columns) {
  Matrix A(rows, columns);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = random.real(-1.0, 1.0);
  return A;
}

Matrix random_definite(plain::Random& random, int n) {
  const Matrix A = random_matrix(random, n, n + 3);
  return A * A.transpose();
}

double sorted_median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// Orders that make a partition slow: rising, falling, all equal, an organ pipe, two values, and any.
double in_order(int order, int i, int n, plain::Random& random) {
  switch (order) {
    case 0:
      return i;
    case 1:
      return -i;
    case 2:
      return 3.0;
    case 3:
      return std::min(i, n - i);
    case 4:
      return i % 2;
    default:
      return random.real(-1.0, 1.0);
  }
}

}  // namespace

TEST_CASE("the median is that of the sorted values") {
  plain::Random random(301);
  for (int order = 0; order < 6; ++order) {
    for (int n = 1; n < 300; n += n < 20 ? 1 : 37) {
      std::vector<double> values;
      for (int i = 0; i < n; ++i) values.push_back(in_order(order, i, n, random));
      const double expected = sorted_median(values);
      CHECK(math::median(values.data(), n) == expected);
    }
  }
}

TEST_CASE("where the middle of three is always a bad pivot the median is the same") {
  // Made against the partition's choice of pivots (M. D. McIlroy, "A killer adversary for quicksort", 1999): each takes
  // two values off, so that the rest is sorted after as many rounds as are allowed.
  std::vector<double> values;
  for (int i = 0; i < 63; ++i) values.push_back(i % 2 == 0 ? i : i == 1 ? 66 : i == 3 ? 64 : 64 + (i + 1) / 2);
  for (int i = 1; i < 66; i += 2) values.push_back(i);
  for (int i = 96; i < 128; ++i) values.push_back(i);
  CHECK(math::median(values.data(), 128) == 63.5);
}

TEST_CASE("a factor, what it solves and its inverse") {
  plain::Random random(302);
  for (const int n : {1, 2, 7, 40}) {
    const Matrix A = random_definite(random, n);
    Matrix U = A;
    REQUIRE(math::cholesky(U.data(), n));
    U = U.triangularView<Eigen::Upper>();
    CHECK((U.transpose() * U - A).cwiseAbs().maxCoeff() < 1e-12);
    const Matrix B = random_matrix(random, n, 5);
    Matrix X = B;
    math::solve_lower(U.data(), n, X.data(), 5);
    CHECK((U.transpose() * X - B).cwiseAbs().maxCoeff() < 1e-10);
    X = B;
    math::solve_upper(U.data(), n, X.data(), 5);
    CHECK((U * X - B).cwiseAbs().maxCoeff() < 1e-10);
    Matrix L(n, n);
    math::inverse_lower(U.data(), n, L.data());
    CHECK((L * U.transpose() - Matrix::Identity(n, n)).cwiseAbs().maxCoeff() < 1e-10);
  }
}

TEST_CASE("what is not positive definite has no factor") {
  Matrix A = Matrix::Identity(3, 3);
  A(2, 2) = 0.0;
  CHECK_FALSE(math::cholesky(A.data(), 3));
  A = Matrix::Ones(3, 3);
  A(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(math::cholesky(A.data(), 3));
}

TEST_CASE("squares of matrices") {
  plain::Random random(303);
  const Matrix B = random_matrix(random, 9, 6);
  Matrix A = Matrix::Zero(6, 6);
  math::add_square(0.5, B.data(), 9, 6, A.data());
  math::mirror(A.data(), 6);
  CHECK((A - 0.5 * B.transpose() * B).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("eigenvalues and -vectors of symmetric matrices, also of bad condition") {
  plain::Random random(304);
  for (int i = 0; i < 50; ++i) {
    Matrix A = random_definite(random, 6);
    if (i % 2 == 1) {
      const Matrix B = random_matrix(random, 6, 2);
      A = B * B.transpose() + 1e-9 * A;
    }
    Matrix used = A, V(6, 6);
    Eigen::VectorXd values(6);
    math::eigen_symmetric(used.data(), 6, values.data(), V.data());
    CHECK((V * values.asDiagonal() * V.transpose() - A).cwiseAbs().maxCoeff() < 1e-13);
    CHECK((V.transpose() * V - Matrix::Identity(6, 6)).cwiseAbs().maxCoeff() < 1e-14);
    std::sort(values.data(), values.data() + 6);
    const Eigen::SelfAdjointEigenSolver<Matrix> expected(A);
    CHECK((values - expected.eigenvalues()).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("rotations of every angle") {
  plain::Random random(305);
  for (const double angle : {0.0, 1e-9, 9e-5, 1.1e-4, 0.3, 3.0, 6.0}) {
    const Eigen::Vector3d axis = random_matrix(random, 3, 1).col(0).normalized();
    const Eigen::Vector3d omega = angle * axis;
    Matrix3 R;
    math::exp_rotation(omega.data(), R.data());
    CHECK((R - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).cwiseAbs().maxCoeff() < 1e-15);
  }
}

TEST_CASE("a pose is moved in the outer frame") {
  plain::Random random(306);
  const Eigen::Vector3d p = random_matrix(random, 3, 1).col(0), turn(0.1, -0.2, 0.3);
  const Matrix3 R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  math::Transform T;
  std::copy(R.data(), R.data() + 9, T.R);
  std::copy(p.data(), p.data() + 3, T.p);
  const double delta[6] = {0.01, 0.02, -0.03, turn.x(), turn.y(), turn.z()};
  const math::Transform moved = math::perturb(T, delta);
  const Matrix3 expected = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * R;
  CHECK((Eigen::Map<const Matrix3>(moved.R) - expected).cwiseAbs().maxCoeff() < 1e-15);
  CHECK((Eigen::Map<const Eigen::Vector3d>(moved.p) - p - Eigen::Vector3d(0.01, 0.02, -0.03)).norm() < 1e-16);
}

TEST_CASE("the nearest rotation is that of the singular vectors") {
  plain::Random random(307);
  for (int i = 0; i < 20; ++i) {
    const Matrix3 R =
        Eigen::AngleAxisd(random.real(0.0, 3.0), random_matrix(random, 3, 1).col(0).normalized()).toRotationMatrix();
    const Matrix3 off = R + 1e-3 * random_matrix(random, 3, 3);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(off, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 found = off;
    math::orthonormalise(found.data());
    CHECK((found - svd.matrixU() * svd.matrixV().transpose()).cwiseAbs().maxCoeff() < 1e-14);
  }
}
