// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/column_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace tactel::fem {
namespace {

// Mesh column of a node: the surface node at or next to the right of it. Ordered from left to right.
int column_of(const Mesh& mesh, int node) {
  const double spacing = mesh.node(0, mesh.surface[1]) - mesh.node(0, mesh.surface[0]);
  const double x = mesh.node(0, node) - 1e-6 * spacing;
  const auto left_of = [&](int surface) { return mesh.node(0, surface) <= x; };
  return int(std::partition_point(mesh.surface.begin(), mesh.surface.end(), left_of) - mesh.surface.begin());
}

}  // namespace

ColumnOrder order_by_column(const Mesh& mesh) {
  const int nodes = int(mesh.node.cols());
  std::vector<int> column(nodes);
  for (int k = 0; k < nodes; ++k) column[k] = column_of(mesh, k);
  for (int k : mesh.base) column[k] = -1;  // clamped
  std::vector<int> by_column(nodes);
  std::iota(by_column.begin(), by_column.end(), 0);
  const auto key = [&](int k) { return std::tuple(column[k], mesh.node(1, k), mesh.node(0, k)); };
  std::sort(by_column.begin(), by_column.end(), [&](int a, int b) { return key(a) < key(b); });

  ColumnOrder order;
  order.place.assign(2 * nodes, -1);
  for (int k : by_column) {
    if (column[k] < 0) continue;
    while (int(order.first.size()) <= column[k]) order.first.push_back(int(order.dof.size()));
    for (int dof : {2 * k, 2 * k + 1}) {
      order.place[dof] = int(order.dof.size());
      order.dof.push_back(dof);
    }
  }
  order.first.push_back(int(order.dof.size()));
  return order;
}

int band_of(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order) {
  int band = 0;
  for (int j = 0; j < order.size(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(stiffness, order.dof[j]); entry; ++entry) {
      const int i = order.place[entry.row()];
      if (i >= 0) band = std::max(band, std::abs(i - j));
    }
  }
  for (int c = 0; c < order.columns(); ++c) band = std::max(band, order.first[c + 1] - order.first[c] - 1);
  return band + 1;  // the y row of a node, one further down, is added to its x row
}

Eigen::SparseMatrix<double> ordered(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < order.size(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(stiffness, order.dof[j]); entry; ++entry) {
      if (order.place[entry.row()] >= 0) entries.emplace_back(order.place[entry.row()], j, entry.value());
    }
  }
  Eigen::SparseMatrix<double> result(order.size(), order.size());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace tactel::fem
