// SPDX-License-Identifier: MIT
// Cholesky factorization of sparse symmetric matrices made of dense blocks, one block for each pair
// of keyframes that share points.
#pragma once

#include "edvo/window/keyframe_unknowns.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace edvo {

// L L' of a positive definite matrix, in place: blocks are added, then factorized, then solved for.
// Blocks are ordered by approximate minimum degree (Amestoy, Davis, Duff 1996). The order of work
// is fixed by the pattern.
class BlockCholesky {
 public:
  // count: of block rows. pattern: (row, column) of all blocks below the diagonal that may be added
  // to; those on it always may.
  BlockCholesky(int count, std::span<const std::pair<int, int>> pattern);

  void set_zero();

  // row, column: of a block in the pattern, either way round.
  void add(int row, int column, const BlockMatrix& block);

  // The diagonal grown by this factor first. False if the matrix is not positive definite.
  [[nodiscard]] bool factorize(double diagonal_factor);

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const;

 private:
  using BlockMap = Eigen::Map<BlockMatrix>;
  using ConstBlockMap = Eigen::Map<const BlockMatrix>;

  // Below the diagonal. Columns and rows are in the order of elimination.
  struct Column {
    std::vector<int> rows;  // ascending
    std::size_t first = 0;  // of its blocks, the diagonal one and then those of rows
  };

  void make_columns(std::span<const std::pair<int, int>> pattern);
  [[nodiscard]] double* block(const Column& column, std::size_t index) {
    return values_.data() + (column.first + index) * BlockMatrix::SizeAtCompileTime;
  }
  [[nodiscard]] const double* block(const Column& column, std::size_t index) const {
    return values_.data() + (column.first + index) * BlockMatrix::SizeAtCompileTime;
  }

  std::vector<int> place_;  // of each block row in the order of elimination
  std::vector<Column> columns_;
  std::vector<double> values_;  // blocks, column-major
};

}  // namespace edvo
