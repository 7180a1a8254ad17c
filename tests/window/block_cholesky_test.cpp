// SPDX-License-Identifier: MIT
#include "edvo/window/block_cholesky.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <random>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;

struct System {
  std::vector<std::pair<int, int>> pattern;
  Eigen::MatrixXd matrix;
};

// A chain of blocks with some far ones, as loops make them.
System chain_with_loops(int count) {
  System system;
  std::mt19937 random(7);
  std::uniform_int_distribution<int> any(0, count - 1);
  for (int i = 1; i < count; ++i)
    for (int j = std::max(0, i - 3); j < i; ++j) system.pattern.emplace_back(i, j);
  for (int k = 0; k < count / 2; ++k)
    if (const auto [i, j] = std::pair(any(random), any(random)); i > j)
      system.pattern.emplace_back(i, j);
  system.matrix = Eigen::MatrixXd::Zero(kN * count, kN * count);
  std::srand(3);
  for (const auto& [i, j] : system.pattern) {
    const BlockMatrix block = BlockMatrix::Random();
    system.matrix.block<kN, kN>(kN * i, kN * j) = block;
    system.matrix.block<kN, kN>(kN * j, kN * i) = block.transpose();
  }
  system.matrix.diagonal().setConstant(200);
  return system;
}

BlockCholesky cholesky_of(const System& system) {
  const auto count = static_cast<int>(system.matrix.rows()) / kN;
  BlockCholesky cholesky(count, system.pattern);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j <= i; ++j)
      if (const BlockMatrix block = system.matrix.block<kN, kN>(kN * i, kN * j); !block.isZero())
        cholesky.add(i, j, block);
  return cholesky;
}

TEST(BlockCholesky, SolvesAsADenseOneDoes) {
  const System system = chain_with_loops(30);
  BlockCholesky cholesky = cholesky_of(system);
  ASSERT_TRUE(cholesky.factorize(1.5));
  Eigen::MatrixXd damped = system.matrix;
  damped.diagonal() *= 1.5;
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(damped.rows(), -1, 2);
  EXPECT_LT((cholesky.solve(right) - damped.ldlt().solve(right)).norm(), 1e-12);
}

TEST(BlockCholesky, TakesABlockEitherWayRound) {
  const System system = chain_with_loops(5);
  BlockCholesky one = cholesky_of(system), other = cholesky_of(system);
  const BlockMatrix block = BlockMatrix::Random();
  one.add(4, 2, block);
  other.add(2, 4, block.transpose());
  ASSERT_TRUE(one.factorize(1) && other.factorize(1));
  const Eigen::VectorXd right = Eigen::VectorXd::Ones(system.matrix.rows());
  EXPECT_EQ(one.solve(right), other.solve(right));
}

TEST(BlockCholesky, IsUsedAgainAfterSetZero) {
  const System system = chain_with_loops(12);
  BlockCholesky cholesky = cholesky_of(system);
  ASSERT_TRUE(cholesky.factorize(1));
  cholesky.set_zero();
  for (int i = 0; i < 12; ++i) cholesky.add(i, i, 2 * BlockMatrix::Identity());
  ASSERT_TRUE(cholesky.factorize(1));
  const Eigen::VectorXd right = Eigen::VectorXd::Ones(system.matrix.rows());
  EXPECT_LT((cholesky.solve(right) - 0.5 * right).norm(), 1e-12);
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  System system = chain_with_loops(6);
  system.matrix(20, 20) = -1;
  EXPECT_FALSE(cholesky_of(system).factorize(1));
}

}  // namespace
}  // namespace edvo
