#pragma once
#include "fem/condensation.h"

namespace tactel::fem {

/// Fewer gap elements than the block has columns: one at every `columns`-th. The force of a gap element acts on the
/// block as a hat that falls to zero at its neighbours, f = W f_c with columns of W that sum to 1, and the displacement
/// that it sees is the mean under the hat, u_c = W^T u, so that C_c = W^T C W stays symmetric positive definite and
/// work is conserved. (A force on the one node instead would dig a dent as deep as the mesh is fine.) `columns` must
/// divide the block's columns less one; else throws std::invalid_argument. 1 changes nothing.
Condensation spread(const Condensation& block, int columns);

/// W: [block columns, gap elements].
Eigen::MatrixXd spread_weights(Eigen::Index block_columns, int columns);

}  // namespace tactel::fem
