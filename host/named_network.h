#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/contact_set.h"
#include "host/executor.h"
#include "nn/metrics.h"
#include "nn/model.h"

namespace tactel::host {

/// A trained network and the name of its file.
struct NamedNetwork {
  std::string file;
  nn::Model model;
};

/// "42-42-21-1_noise0.1_seed7.onnx".
std::string network_file_name(const nn::Topology& topology, double noise, std::uint64_t seed);
/// 1 ... 6 for the paper's topologies, else 0.
int paper_number(const nn::Topology& topology);

/// One network file, or all *.onnx of a directory: the paper's networks in its order, then others, by noise and seed.
/// Throws ConfigError for a path without networks, and as read_onnx.
std::vector<NamedNetwork> read_networks(const std::filesystem::path& path);

/// The rows of a set that networks can learn from or be judged by: solved within tolerance, with a slippage index.
struct AnsweredRows {
  nn::FrameSet frames;
  std::vector<std::size_t> row;  ///< [frames.rows()] which row of the file
  std::size_t left_out = 0;
};
/// Throws ConfigError naming `file` when no row is left.
AnsweredRows answered_rows(const ContactSet& set, const std::string& file);

/// What a network made of a set.
struct NetworkResult {
  nn::ErrorReport errors;
  std::array<std::size_t, 4> frames{};  ///< how many had each nn::FrameStatus
  std::vector<float> slip_index{};      ///< [rows] if asked for; NaN where the network gave none
};

/// Every network on every row, in the order of `networks`; none when progress says no. Throws ConfigError, naming the
/// network's file, for frames of another width.
template <class Real>
std::optional<std::vector<NetworkResult>> recall_networks(Executor& executor, std::span<const NamedNetwork> networks,
                                                          const nn::FrameSet& set, bool keep_rows,
                                                          const Progress& progress);

extern template std::optional<std::vector<NetworkResult>> recall_networks<float>(Executor&,
                                                                                 std::span<const NamedNetwork>,
                                                                                 const nn::FrameSet&, bool,
                                                                                 const Progress&);
extern template std::optional<std::vector<NetworkResult>> recall_networks<double>(Executor&,
                                                                                  std::span<const NamedNetwork>,
                                                                                  const nn::FrameSet&, bool,
                                                                                  const Progress&);

}  // namespace tactel::host
