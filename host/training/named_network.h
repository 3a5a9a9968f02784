// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/support/precision.h"
#include "host/training/answered_rows.h"
#include "host/training/bound_report.h"
#include "nn/metrics.h"
#include "nn/model.h"

namespace tactel::host {

/// A trained network and the name of its file.
struct NamedNetwork {
  std::string file;
  nn::Model model;
};

/// Returns 1 ... 6 for the paper's topologies, else 0.
int paper_number(const nn::Topology& topology);

/// Reads one network file, one of the library by its name, or all *.onnx of a directory: the networks of the paper in
/// its order, then others, by noise and seed. Throws ConfigError for a path without networks, and as read_onnx.
std::vector<NamedNetwork> read_networks(const std::filesystem::path& path);

inline constexpr double told_nothing = std::numeric_limits<double>::infinity();

/// Answers of a network to a set.
struct NetworkResult {
  nn::ErrorReport errors;
  std::array<std::size_t, 4> frames{};    ///< number of frames of each nn::FrameStatus
  std::vector<float> slip_index{};        ///< [rows] if requested; NaN where the network gave none
  std::optional<BoundReport> bound{};     ///< of a network with a bound
  std::vector<nn::BoundAnswer> bounds{};  ///< [rows] of a network with a bound, if requested
  std::vector<float> truth{};             ///< [rows] what the network is to answer, if requested
};

/// Evaluates every network on every row, in the order of `networks`. spread: of what is told of mu (nn::with_history);
/// infinity: nothing. Returns none where progress stops it. Throws
/// ConfigError, naming the file of the network, for frames of another width or other inputs.
std::optional<std::vector<NetworkResult>> recall_networks(Executor& executor, Precision precision,
                                                          std::span<const NamedNetwork> networks,
                                                          const nn::FrameSet& set, bool keep_rows,
                                                          const Progress& progress, double spread = told_nothing);

/// Calibrates the bound of a network anew by the rows of a set, in the classes of today (nn::renew_classes): in fp32,
/// as monitor and the libraries evaluate it. `file`: of the set, for errors and the network's metadata. Throws
/// ConfigError, naming the network's file or the set's, for a network without a bound, frames of another width, and too
/// few rows.
nn::Calibration calibrate_bound(Executor& executor, NamedNetwork& network, const ContactSet& set,
                                const std::string& file, double level);

}  // namespace tactel::host
