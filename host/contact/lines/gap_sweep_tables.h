// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::host {

/// Tables of a sensor for kernels/gap_sweep.cl, from fem::Condensation, for E = 1.

/// Of C: [columns][columns][COMPLIANCE_PARTS], with n pressing down (-y). Without friction the first part alone:
/// [columns][columns].
template <class Real>
std::vector<Real> compliance_table(const Eigen::MatrixXd& compliance, bool friction);

/// Returns the rows of NodeRow for each surface node: [columns][NODE_ROWS].
template <class Real>
std::vector<Real> node_table(const Eigen::MatrixXd& compliance);

/// Returns the table of a map from surface loads to output rows: [blocks of rows][columns][ROW_BLOCK][2], by n,
/// by t. Rows beyond the last are zero.
template <class Real>
std::vector<Real> output_table(const Eigen::MatrixXd& map);

}  // namespace tactel::host
