#pragma once
#include "fem/condensation.h"

namespace tactel::fem {

/// Returns a condensation with fewer gap elements than the block has columns: one at every `columns`-th. The
/// force of a gap element acts on the block as a hat that falls to zero at its neighbours: f = W f_c, where the
/// columns of W sum to 1. Its displacement is the mean under the hat, u_c = W^T u. C_c = W^T C W therefore stays
/// symmetric positive definite, and work is conserved. (The dent of a force on one node would become deeper as
/// the mesh becomes finer.) 1 changes nothing. Throws std::invalid_argument unless `columns` divides the number
/// of columns of the block less one.
Condensation spread(const Condensation& block, int columns);

/// Returns W: [block columns, gap elements].
Eigen::MatrixXd spread_weights(Eigen::Index block_columns, int columns);

}  // namespace tactel::fem
