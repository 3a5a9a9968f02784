#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::host {

/// What kernels/gap_sweep.cl reads of a sensor, from fem::Condensation, for E = 1.

/// Of C: [columns][columns][4], u_y by n, u_y by t, u_x by n, u_x by t, with n pressing down (-y). Without friction the
/// first of them alone: [columns][columns].
template <class Real>
std::vector<Real> compliance_table(const Eigen::MatrixXd& compliance, bool friction);

/// Rows of NodeRow for each surface node: [columns][NODE_ROWS].
template <class Real>
std::vector<Real> node_table(const Eigen::MatrixXd& compliance);

/// Of a map from surface loads to output rows: [blocks of rows][columns][ROW_BLOCK][2], by n, by t; rows beyond the
/// last are zero.
template <class Real>
std::vector<Real> output_table(const Eigen::MatrixXd& map);

}  // namespace tactel::host
