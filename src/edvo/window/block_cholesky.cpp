// SPDX-License-Identifier: MIT
#include "edvo/window/block_cholesky.hpp"

#include "edvo/simd/dispatch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <iterator>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr std::size_t kSize = BlockMatrix::SizeAtCompileTime;

// Subtracts blocks * b' from blocks of another column; index: of each of them there.
EDVO_CLONES void subtract_products(const double* blocks, const std::vector<std::size_t>& index,
                                   const double* b, double* column) {
  for (const std::size_t at : index) {
    double* const target = column + at * kSize;
    for (int c = 0; c < kN; ++c) {
      double sum[kN];
      for (int r = 0; r < kN; ++r) sum[r] = target[c * kN + r];
      for (int k = 0; k < kN; ++k)
        for (int r = 0; r < kN; ++r) sum[r] -= blocks[k * kN + r] * b[k * kN + c];
      for (int r = 0; r < kN; ++r) target[c * kN + r] = sum[r];
    }
    blocks += kSize;
  }
}

// blocks * L'^-1, L: lower triangular.
EDVO_CLONES void divide(double* blocks, std::size_t count, const double* lower) {
  for (std::size_t i = 0; i < count; ++i, blocks += kSize)
    for (int c = 0; c < kN; ++c) {
      double sum[kN];
      for (int r = 0; r < kN; ++r) sum[r] = blocks[c * kN + r];
      for (int k = 0; k < c; ++k)
        for (int r = 0; r < kN; ++r) sum[r] -= blocks[k * kN + r] * lower[k * kN + c];
      const double inverse = 1 / lower[c * kN + c];
      for (int r = 0; r < kN; ++r) blocks[c * kN + r] = inverse * sum[r];
    }
}

std::vector<int> elimination_order(int count, std::span<const std::pair<int, int>> pattern) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [row, column] : pattern) {
    entries.emplace_back(row, column, 1.0);
    entries.emplace_back(column, row, 1.0);
  }
  Eigen::SparseMatrix<double> graph(count, count);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(graph, order);
  std::vector<int> place(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) place[static_cast<std::size_t>(order.indices()[i])] = i;
  return place;
}

}  // namespace

BlockCholesky::BlockCholesky(int count, std::span<const std::pair<int, int>> pattern)
    : place_(elimination_order(count, pattern)), columns_(static_cast<std::size_t>(count)) {
  make_columns(pattern);
}

// With the blocks that elimination fills: a column has all rows of those eliminated before it whose
// first row below the diagonal it is.
void BlockCholesky::make_columns(std::span<const std::pair<int, int>> pattern) {
  for (const auto& [row, column] : pattern) {
    const auto [low, high] = std::minmax(place_[static_cast<std::size_t>(row)],
                                         place_[static_cast<std::size_t>(column)]);
    columns_[static_cast<std::size_t>(low)].rows.push_back(high);
  }
  std::size_t blocks = 0;
  for (Column& column : columns_) {
    std::vector<int>& rows = column.rows;
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    column.first = blocks;
    blocks += 1 + rows.size();
    if (rows.empty()) continue;
    std::vector<int>& next = columns_[static_cast<std::size_t>(rows.front())].rows;
    next.insert(next.end(), rows.begin() + 1, rows.end());
  }
  values_.resize(blocks * kSize);
}

void BlockCholesky::set_zero() {
  std::fill(values_.begin(), values_.end(), 0.0);
}

void BlockCholesky::add(int row, int column, const BlockMatrix& block_to_add) {
  const int i = place_[static_cast<std::size_t>(row)], j = place_[static_cast<std::size_t>(column)];
  const Column& target = columns_[static_cast<std::size_t>(std::min(i, j))];
  std::size_t index = 0;
  if (i != j) {
    const auto at = std::lower_bound(target.rows.begin(), target.rows.end(), std::max(i, j));
    index = 1 + static_cast<std::size_t>(at - target.rows.begin());
  }
  BlockMap sum(block(target, index));
  if (i >= j)
    sum += block_to_add;
  else
    sum += block_to_add.transpose();
}

// Column by column: what those before it take off, then its own factor.
bool BlockCholesky::factorize(double diagonal_factor) {
  const std::size_t count = columns_.size();
  // Columns whose next row to be used is this one, and which that is.
  std::vector<std::vector<std::size_t>> users(count);
  std::vector<std::size_t> next(count, 0), index_of(count, 0), index;
  for (std::size_t j = 0; j < count; ++j) {
    Column& column = columns_[j];
    BlockMap diagonal(block(column, 0));
    diagonal.diagonal() *= diagonal_factor;
    for (std::size_t k = 0; k < column.rows.size(); ++k)
      index_of[static_cast<std::size_t>(column.rows[k])] = k + 1;
    index_of[j] = 0;
    for (const std::size_t k : users[j]) {
      const Column& before = columns_[k];
      index.clear();
      for (std::size_t r = next[k]; r < before.rows.size(); ++r)
        index.push_back(index_of[static_cast<std::size_t>(before.rows[r])]);
      const double* const blocks = block(before, 1 + next[k]);
      subtract_products(blocks, index, blocks, block(column, 0));
      if (++next[k] < before.rows.size())
        users[static_cast<std::size_t>(before.rows[next[k]])].push_back(k);
    }
    const Eigen::LLT<BlockMatrix> own(diagonal);
    if (own.info() != Eigen::Success) return false;
    diagonal = own.matrixL();
    divide(block(column, 1), column.rows.size(), block(column, 0));
    if (!column.rows.empty()) users[static_cast<std::size_t>(column.rows.front())].push_back(j);
  }
  return true;
}

Eigen::VectorXd BlockCholesky::solve(const Eigen::VectorXd& right) const {
  Eigen::VectorXd x(right.size());
  for (std::size_t i = 0; i < place_.size(); ++i)
    x.segment<kN>(kN * place_[i]) = right.segment<kN>(kN * static_cast<Eigen::Index>(i));
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const Column& column = columns_[j];
    auto own = x.segment<kN>(kN * static_cast<Eigen::Index>(j));
    ConstBlockMap(block(column, 0)).triangularView<Eigen::Lower>().solveInPlace(own);
    for (std::size_t k = 0; k < column.rows.size(); ++k)
      x.segment<kN>(kN * column.rows[k]) -= ConstBlockMap(block(column, k + 1)) * own;
  }
  for (std::size_t j = columns_.size(); j-- > 0;) {
    const Column& column = columns_[j];
    auto own = x.segment<kN>(kN * static_cast<Eigen::Index>(j));
    for (std::size_t k = 0; k < column.rows.size(); ++k)
      own -= ConstBlockMap(block(column, k + 1)).transpose() * x.segment<kN>(kN * column.rows[k]);
    ConstBlockMap(block(column, 0)).transpose().triangularView<Eigen::Upper>().solveInPlace(own);
  }
  Eigen::VectorXd solution(right.size());
  for (std::size_t i = 0; i < place_.size(); ++i)
    solution.segment<kN>(kN * static_cast<Eigen::Index>(i)) = x.segment<kN>(kN * place_[i]);
  return solution;
}

}  // namespace edvo
