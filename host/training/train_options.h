// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/train_options.h>

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>

#include "host/support/tables.h"

namespace tactel::host {

/// A training as the command line asks for it: on files, or by simulation.
struct TrainRequest : TrainOptions {
  TrainRequest() { networks.clear(), schedule.clear(); }  // all six; "online", or "batch" of a stream
  explicit TrainRequest(const TrainOptions& options) : TrainOptions(options) {}

  std::string set{}, stream{}, recall_set{}, validation_set{}, output{};
  std::string rung{};                   ///< of the contacts of `stream`; empty: as its file says
  std::optional<std::int64_t> block{};  ///< rows of a set file to read at a time
  std::optional<std::uint64_t> rows{};  ///< of a stream to learn from; default_rows if not given
  bool magnitude = false;               ///< learn |S|
  std::optional<double> alarm_at{};     ///< of targets that are slides
  std::string activation{};             ///< empty: as `networks` say
  std::string bound_set{};              ///< by which the bound is calibrated; empty: it is not
  double checkpoint_seconds = 10;
  bool resume = false, force = false, quiet = false;

  /// Frames block by block: simulated contacts, or a set file larger than memory.
  bool streams() const { return !stream.empty() || block.has_value(); }
  /// Images of a line's frame have S of both signs.
  bool learns_magnitude() const { return magnitude || features == "line"; }
  bool cosine() const { return schedule == "cosine"; }
  bool markers() const { return inputs == "markers"; }
  bool batches() const { return streams() || cosine() || schedule == "batch"; }
};
inline constexpr std::uint64_t default_rows = 10'000'000;

/// Every option that says how and from what a training learns.
inline constexpr std::tuple train_options{
    Option("--network", &TrainRequest::networks, "Network:1",
           "1 to 6 of the paper, or widths such as 42-42-21-1; repeatable (default: all six)", {.type = "N|WIDTHS"}),
    Option("--seeds", &TrainRequest::seeds, "Learning:3", "number of networks of each kind, with consecutive seeds",
           {.positive = true}),
    Option("--first-seed,--seed", &TrainRequest::first_seed, "Learning:4",
           "first seed of initial weights, order and noise"),
    Option("--inputs", &TrainRequest::inputs, "Input:7",
           "what networks take: stresses, or markers, how each moves along x and y, mm, of pads with [markers]",
           {.words = {"stresses", "markers"}}),
    Option("--noise", &TrainRequest::noises, "Input:4",
           "standard deviation of Gaussian noise on the learning set over its largest |input|, 0.1 for 10 %; "
           "repeatable (default: 0)"),
    Option("--scaling", &TrainRequest::scaling, "Network:5",
           "divisor of the stresses: set, the learning set's largest |stress|; frame, each frame's own largest normal "
           "stress; rest, the normal force of the grip at rest, of differences to it",
           {.words = {"set", "frame", "rest"}}),
    Option("--history", &TrainRequest::history, "Network:2",
           "number of frames in an input: the newest and earlier ones of its contact; with :STRIDE every STRIDE-th of "
           "these (default: 1)",
           {.type = "K[:STRIDE]"}),
    Option("--history-change", &TrainRequest::history_change, "Network:3",
           "with --history: a frame is kept that differs by more than this share of the contact's largest stress from "
           "the last kept one, 0 to 1 (default: 0.1)"),
    Option("--magnitude", &TrainRequest::magnitude, "Input:6", "learn |S|: for drags to both sides"),
    Option("--friction", &TrainRequest::friction, "Network:4",
           "networks take mu as far as it is known: a number and its relative spread, which `monitor --friction` and "
           "alarms tell; also nothing"),
    Option("--features", &TrainRequest::features, "Network:6",
           "fixed layer before the network, with --scaling frame or rest: line or pad, one of all mirror images of a "
           "frame and its sums; line learns |S|; frame: none",
           {.words = {"frame", "line", "pad"}}),
    Option("--target", &TrainRequest::target, "Input:5",
           "column of the set to learn: slip_index, S; force_ratio, |Q| / (mu P) of pads; stick_fraction; slid, how "
           "far pads slid since rest as a whole; slip_path, how far their cells did; net_slip, how far these got; "
           "slid_ahead, how far grips slide in the next 0.2 s",
           {.words = {"slip_index", "force_ratio", "stick_fraction", "slid", "slip_path", "net_slip", "slid_ahead"}}),
    Option("--alarm-at", &TrainRequest::alarm_at, "Alarm:1",
           "with --target of a slide: threshold of `tactel monitor --alarm` that the network's file holds, "
           "above 0 and below 1 (default: none)",
           {.type = "FLOAT", .least = 1e-3, .most = 0.999}),
    Option("--schedule", &TrainRequest::schedule, "Learning:1",
           "online: pattern by pattern (the paper's); batch: mini-batches, for large sets; cosine: mini-batches at a "
           "learning rate that warms up and falls to 0 as a cosine (default: online; with --stream and --block batch)",
           {.words = {"online", "batch", "cosine"}}),
    Option("--cycles,--epochs", &TrainRequest::cycles, "Learning:2",
           "most passes over the set (default: 10000, 15000 with two hidden layers, 1000 with --schedule batch)"),
    Option("--learning-rate", &TrainRequest::rate, "Learning:7",
           "learning rate, no unit (default: 0.1, for adam 0.001, of cosine 0.002)", {.key = "rate"}),
    Option("--warm-up", &TrainRequest::warm_up, "Learning:8",
           "with --schedule cosine: share of the training in which the learning rate rises from 0 to its largest "
           "(default: 0.02)"),
    Option("--momentum", &TrainRequest::momentum, "Learning:9",
           "share of the last step in the next one, 0 to 1 (default: 0.9); not for adam"),
    Option("--stop-error", &TrainRequest::stop_error, "Learning:14",
           "a network stops when every |error| of S in a cycle is below this, no unit; 0: never (default: 0.01)"),
    Option("--order", &TrainRequest::order, "Learning:15", "order of the rows in a cycle",
           {.words = {"permuted", "sequential"}}),
    Option("--batch", &TrainRequest::batch, "Learning:5",
           "rows that a change of the weights learns from, in mini-batches (default: 64)"),
    Option("--optimizer", &TrainRequest::optimizer, "Learning:6",
           "of mini-batches: delta (the delta rule with momentum) or adam (default: adam)",
           {.words = {"delta", "adam"}}),
    Option("--loss", &TrainRequest::loss, "Learning:10",
           "of mini-batches: squared or absolute error of S, whose mean becomes small (default: squared); quantiles "
           "have their own",
           {.words = {"squared", "absolute"}}),
    Option("--average", &TrainRequest::average, "Learning:11",
           "of mini-batches: decay, in a change of the weights, of their exponential mean, which is the network; 0: "
           "none (default: 0; 0.9995 takes the mean of some 2000)"),
    Option("--validation", &TrainRequest::validation_set, "Learning:12",
           "of mini-batches: set that judges the networks after each cycle or block; a network keeps the weights of "
           "the smallest mean error",
           {.type = "SET.h5"}),
    Option(
        "--patience", &TrainRequest::patience, "Learning:13",
        "with --validation: a network stops after so many cycles or blocks without a smaller error (default: never)"),
    Option("--activation", &TrainRequest::activation, "Network:7",
           "of mini-batches: function of the hidden neurons, logistic (the paper's) or leaky-relu, which learns large "
           "sets better (default: logistic)",
           {.words = {"logistic", "leaky-relu"}}),
    Option("--bound", &TrainRequest::bound, "Network:8",
           "of mini-batches: three outputs, S and two quantiles, for an upper bound of S; it holds after --bound-set "
           "or tactel calibrate bound"),
    Option("--bound-set", &TrainRequest::bound_set, "Network:9",
           "with --bound: set of another seed, by whose rows the bound becomes conformal at the end",
           {.type = "SET.h5"}),
    Option("--level", &TrainRequest::level, "Network:10", "with --bound: level of the upper quantile (default: 0.95)"),
    Option("--stream", &TrainRequest::stream, "Input:1",
           "instead of a set: contacts of this sweep file, simulated on demand and never stored",
           {.type = "SWEEP.toml"}),
    Option("--rung", &TrainRequest::rung, "Accuracy:1",
           "with --stream: model of its contacts, as `tactel generate` takes it", {.type = "NAME"}),
    Option("--rows", &TrainRequest::rows, "Input:2",
           "number of rows of --stream or --block to learn from (default: 10000000)", {.positive = true}),
    Option("--block", &TrainRequest::block, "Input:3",
           "read the set in blocks of this many rows: for sets larger than memory",
           {.type = "ROWS", .least = 1, .most = 100'000'000})};

}  // namespace tactel::host
