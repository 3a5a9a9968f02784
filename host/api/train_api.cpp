// SPDX-License-Identifier: Apache-2.0
#include <tactel/train.h>

#include <cmath>
#include <utility>

#include "host/api/conversion.h"
#include "host/api/states.h"
#include "host/networks/dense_chain.h"
#include "host/networks/network_training.h"
#include "host/networks/onnx_file.h"
#include "host/training/train_request.h"
#include "nn/infer/network_file.h"

namespace tactel {

namespace {

host::TrainRequest request_of(const TrainOptions& options) {
  api::check_precision(options.precision);
  if (options.schedule != "online" && options.schedule != "batch" && options.schedule != "cosine")
    throw ConfigError("command line", "--schedule", options.schedule, "online, batch or cosine");
  host::TrainRequest request(options);
  if (options.validation != nullptr) request.validation_set = "validation";
  return request;
}

template <class Real>
std::vector<nn::Model> trained(const nn::FrameSet& frames, const host::TrainingPlan& plan, const TrainOptions& options,
                               const ProgressFunction& progress) {
  host::Executor executor{host::training_device(host::Device(options.device), plan)};
  host::NetworkTraining<Real> training(executor, frames, plan);
  host::TrainingRunOptions run;
  run.progress = [&](std::size_t done, std::size_t all) { return progress(done, all); };
  if (!training.run(run)) throw Cancelled("train: cancelled by progress");
  const std::vector<nn::ErrorReport> reports = training.recall_learning_set();
  std::vector<nn::Model> models;
  for (std::size_t i = 0; i < training.networks().size(); ++i)
    if (training.networks()[i].status != nn::TrainStatus::not_finite)
      models.push_back(training.model(i, options.name, reports[i].all));
  return models;
}

}  // namespace

Network::~Network() { delete state_; }
Network::Network(const Network& other) : state_(new State(*other.state_)) {}
Network& Network::operator=(const Network& other) {
  Network copy(other);
  std::swap(state_, copy.state_);
  return *this;
}

namespace {

host::DenseLayer to_host(const DenseLayer& layer) {
  using Activation = host::DenseLayer::Activation;
  if (layer.inputs == 0 || layer.outputs == 0 || layer.weights.size() != layer.inputs * layer.outputs)
    throw ValueError("layers", std::to_string(layer.weights.size()) + " weights",
                     "layers of outputs times inputs weights");
  const auto out = static_cast<Eigen::Index>(layer.outputs), in = static_cast<Eigen::Index>(layer.inputs);
  host::DenseLayer made{
      Eigen::Map<const nn::RowMatrix<float>>(layer.weights.data(), out, in).cast<double>(),
      Eigen::Map<const nn::Vector<float>>(layer.biases.data(), static_cast<Eigen::Index>(layer.biases.size()))
          .cast<double>()};
  if (layer.activation == "tanh")
    made.activation = Activation::tanh;
  else if (layer.activation == "relu" || layer.activation == "leaky-relu")
    made.activation = Activation::leaky_relu, made.slope = layer.activation == "relu" ? 0 : layer.slope;
  else if (layer.activation != "sigmoid")
    throw ValueError("activation", layer.activation, "sigmoid, tanh, relu or leaky-relu");
  return made;
}

}  // namespace

Network Network::from_layers(const std::vector<DenseLayer>& layers, const InputOptions& inputs) {
  return api::with_public_errors([&] {
    host::DenseChain chain;
    for (const DenseLayer& layer : layers) chain.push_back(to_host(layer));
    const auto history = host::parse_history(inputs.history, inputs.history_change);
    const nn::InputScaling scaling{nn::parse_scaling(inputs.scaling), static_cast<float>(inputs.largest_stress), 1,
                                   inputs.axes};
    return Network(new State{std::make_shared<nn::Model>(
        host::model_of_chain(chain, scaling, history, inputs.name, nn::parse_target(inputs.target)))});
  });
}
Network Network::load(const std::string& path) {
  return api::with_public_errors(
      [&] { return Network(new State{std::make_shared<nn::Model>(host::read_onnx(path))}); });
}
Network Network::parse(std::string_view bytes) {
  return api::with_public_errors(
      [&] { return Network(new State{std::make_shared<nn::Model>(infer::read_network(bytes).model)}); }, "network");
}
void Network::to_onnx(const std::string& path) const {
  api::with_public_errors([&] { host::write_onnx(path, *state_->model); }, path);
}
std::string Network::onnx() const { return infer::network_bytes(*state_->model); }
SlipEstimator Network::estimator() const {
  const std::string bytes = onnx();
  return SlipEstimator::parse(std::as_bytes(std::span(bytes)), topology());
}
std::string Network::topology() const { return state_->model->weights.topology.text(); }
std::uint64_t Network::seed() const { return state_->model->seed; }
double Network::noise() const { return state_->model->noise; }
std::uint32_t Network::cycles() const { return state_->model->cycles; }
namespace {

Errors from_nn(const nn::ErrorSummary& errors) { return {errors.max, errors.mean, errors.std, errors.count}; }

/// The rows of a set as its networks see them.
nn::FrameSet shown(const Set& set, const std::string& name, const host::TrainingPlan& plan) {
  host::NamedSet named{name, api::to_host(set), {}};
  named.rows = host::answered_rows(named.contacts, name, plan.target, plan.markers);
  host::check_learnable(named.rows, name);
  host::check_width(plan, named);
  return host::shown_rows(named.rows.frames, plan.history, plan.magnitude, name);
}

}  // namespace

Errors Network::learning_errors() const { return from_nn(state_->model->learning_errors); }

LearningRows learning_rows(const Set& set, const TrainOptions& options) {
  return api::with_public_errors([&] {
    host::TrainingPlan plan = host::plan_of(request_of(options));
    plan.topologies.clear();
    const nn::FrameSet rows = shown(set, options.name, plan);
    return LearningRows{static_cast<std::size_t>(rows.frames.cols()),
                        {rows.frames.data(), rows.frames.data() + rows.frames.size()},
                        {rows.slip_index.begin(), rows.slip_index.end()}};
  });
}

std::vector<Network> train(const Set& set, const TrainOptions& options, const ProgressFunction& progress) {
  std::vector<nn::Model> models = api::with_public_errors([&] {
    const host::TrainRequest request = request_of(options);
    host::TrainingPlan plan = host::plan_of(request);
    const nn::FrameSet frames = shown(set, options.name, plan);
    if (options.validation != nullptr)
      plan.validation = std::make_shared<nn::FrameSet>(shown(*options.validation, "validation", plan));
    return host::in_precision(host::precision_named(options.precision),
                              [&]<class Real>() { return trained<Real>(frames, plan, options, progress); });
  });
  std::vector<Network> networks;
  networks.reserve(models.size());
  for (nn::Model& model : models)
    networks.push_back(Network(new Network::State{std::make_shared<nn::Model>(std::move(model))}));
  return networks;
}

namespace {

/// Answers to all rows [rows], contact by contact.
std::vector<Answer> answers_of(const SlipEstimator& network, const Set& set, std::span<const float> frames) {
  std::vector<Answer> answers(set.rows());
  if (network.frames() == 1) {
    network.estimate(frames, answers);
    return answers;
  }
  if (!set.press_rows || set.contact.size() != set.rows())
    throw InputError("set", "no rows of the pressing", "must have press_rows for a network with history");
  SlipHistory history(network);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (i > 0 && set.contact[i] != set.contact[i - 1]) history.clear();
    answers[i] = history.estimate(frames.subspan(i * history.inputs(), history.inputs()));
  }
  return answers;
}

}  // namespace

Errors errors(const SlipEstimator& network, const Set& set) {
  const host::ContactSet all = api::to_host(set);
  const bool markers = !network.metadata("inputs").empty();
  const int given = host::frame_inputs(all, markers);
  const std::size_t inputs = SlipHistory(network).inputs();
  if (static_cast<std::size_t>(given) != inputs || !all.has(host::unread(!markers)))
    throw InputError("set", std::to_string(given) + (markers ? " inputs of markers" : " inputs"),
                     "must be " + std::to_string(inputs) + " for the network " + network.topology());
  const std::vector<Answer> answers = answers_of(network, set, host::frames_of(all, markers));
  std::vector<double> errors;
  for (std::size_t i = 0; i < set.rows(); ++i) {
    const double error = std::abs(double(answers[i].slip_index) - double(set.slip_index[i]));
    if (all.status[i] != host::over_tolerance && std::isfinite(error)) errors.push_back(error);
  }
  return from_nn(nn::summarize(errors));
}

}  // namespace tactel
