// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>
#include <tactel/progress.h>
#include <tactel/sweep.h>
#include <tactel/train_options.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactel {

/// Errors |S of a network - S of a set|.
struct Errors {
  double largest = 0, mean = 0, deviation = 0;
  std::uint64_t rows = 0;
};

/// A dense layer of a network that another program trained: activation(weights x + biases).
struct DenseLayer {
  std::size_t inputs = 0, outputs = 0;
  std::vector<float> weights;          ///< [outputs, inputs], as torch.nn.Linear.weight
  std::vector<float> biases;           ///< [outputs]
  std::string activation = "sigmoid";  ///< "sigmoid", "tanh", "relu" or "leaky-relu"
  double slope = 0.01;                 ///< of leaky-relu below 0
};

/// How the frames of such a network become its inputs.
struct InputOptions {
  /// "set": divided by largest_stress; "frame": by the frame's largest normal stress; "rest": as TrainOptions::scaling,
  /// so that an input is followed by the rest of its grip
  std::string scaling = "set";
  double largest_stress = 1;               ///< MPa; 1: as they are
  int axes = 2;                            ///< stresses of a tactel: of a pad 3, or 1
  std::string history{};                   ///< "k" or "k:stride", as TrainOptions::history
  std::optional<double> history_change{};  ///< as TrainOptions::history_change
  std::string name = "own";                ///< of the learning set, in the network's metadata
  std::string target = "slip_index";       ///< what it answers, as TrainOptions::target
};

/// A trained network with its origin. Copies are cheap and share it.
class TACTEL_API Network {
 public:
  /// Returns a network of one or two hidden layers, all rectifiers or none, and one output through a sigmoid, which is
  /// S. Its answers are those of the layers, to rounding. Throws InputError for other layers.
  static Network from_layers(const std::vector<DenseLayer>& layers, const InputOptions& inputs = {});
  /// Reads a network file that tactel wrote. Throws InputError.
  static Network load(const std::string& path);
  /// The same from what onnx() returns.
  static Network parse(std::string_view bytes);
  ~Network();
  Network(const Network&);
  Network& operator=(const Network&);

  /// Writes the network file (ONNX, docs/networks.md). Throws InputError where it cannot be written.
  void to_onnx(const std::string& path) const;
  /// Returns the bytes of that file.
  std::string onnx() const;
  /// Returns the network for frames one by one.
  SlipEstimator estimator() const;

  std::string topology() const;  ///< "42-42-21-1"
  std::uint64_t seed() const;
  double noise() const;
  std::uint32_t cycles() const;
  Errors learning_errors() const;  ///< on its learning set, noise included

  struct State;

 private:
  friend class LiveEstimator;
  friend TACTEL_API std::vector<Network> train(const Set& set, const TrainOptions& options,
                                               const ProgressFunction& progress);
  explicit Network(State* state) noexcept : state_(state) {}
  State* state_;
};

/// What train() learns from, for networks of other programs.
struct LearningRows {
  std::size_t inputs = 0;     ///< numbers of a row: frames, the newest first, then the rest, then what is told of mu
  std::vector<float> frames;  ///< [rows, inputs] MPa, before scaling and features
  std::vector<float> target;  ///< [rows] S, or the target of the options
};
/// Returns the rows of a set as train() takes them for these options: by history, rest, friction and target. Throws
/// InputError as train().
TACTEL_API LearningRows learning_rows(const Set& set, const TrainOptions& options);

/// Trains networks on a set: every topology, noise and seed, in this order, seeds fastest. A network that diverges has
/// no entry. Throws InputError for options or a set that cannot be used, HardwareError, and Cancelled where progress
/// (weight updates of the most possible) says so.
TACTEL_API std::vector<Network> train(const Set& set, const TrainOptions& options = {},
                                      const ProgressFunction& progress = {});

/// Returns the errors of a network on a set's rows that have an answer. A network with history takes the rows contact
/// by contact, in their order; the set must have press_rows. One of markers takes those of the set.
TACTEL_API Errors errors(const SlipEstimator& network, const Set& set);

}  // namespace tactel
