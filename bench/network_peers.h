// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <atomic>
#include <thread>
#include <vector>

#include "nn/train_batch.h"

#ifdef TACTEL_FANN
#include <floatfann.h>
#endif

namespace tactel::bench {

/// f of a whole array at once, with Eigen's vectorized tanh.
template <class Array>
auto activation(const Array& z) {
  return 0.5f * (0.5f * z.array()).tanh();
}

/// A network as one would write it by hand in Eigen, fp32: column-major matrices, biases apart. What the kernels are
/// measured against.
struct EigenNetwork {
  explicit EigenNetwork(const nn::Weights<float>& weights) {
    for (int l = 0; l < weights.topology.layers(); ++l) {
      const int in = weights.topology.fan_in(l);
      w.push_back(weights.layer(l).leftCols(in));
      b.push_back(weights.layer(l).col(in));
      w_step.push_back(Eigen::MatrixXf::Zero(w[l].rows(), in));
      b_step.push_back(Eigen::VectorXf::Zero(w[l].rows()));
    }
    o.resize(w.size() + 1);
    d.resize(w.size());
  }

  /// Outputs of the last layer for frames in columns; o keeps every layer's.
  void forward(const Eigen::Ref<const Eigen::MatrixXf>& x) {
    o[0] = x;
    for (std::size_t l = 0; l < w.size(); ++l) {
      o[l + 1].noalias() = w[l] * o[l];
      o[l + 1].colwise() += b[l];
      o[l + 1] = activation(o[l + 1]);
    }
  }

  void backward(const Eigen::Ref<const Eigen::RowVectorXf>& error) {
    d.back() = error.array() * (0.25f - o.back().array().square());
    for (std::size_t l = w.size() - 1; l > 0; --l) {
      d[l - 1].noalias() = w[l].transpose() * d[l];
      d[l - 1].array() *= 0.25f - o[l].array().square();
    }
  }

  /// The delta rule with momentum for what o and d hold.
  void update(float rate, float momentum) {
    for (std::size_t l = 0; l < w.size(); ++l) {
      w_step[l] *= momentum;
      w_step[l].noalias() += (rate * d[l]) * o[l].transpose();
      b_step[l] = momentum * b_step[l] + rate * d[l].rowwise().sum();
      w[l] += w_step[l];
      b[l] += b_step[l];
    }
  }

  std::vector<Eigen::MatrixXf> w, w_step, o, d;
  std::vector<Eigen::VectorXf> b, b_step;
};

/// The same for one pattern at a time: vectors in place of one-column matrices, and the outer product fused with the
/// step.
struct EigenOnline {
  explicit EigenOnline(const nn::Weights<float>& weights)
      : network(weights), o(network.w.size() + 1), d(network.w.size()) {}

  void learn(const Eigen::Ref<const Eigen::VectorXf>& x, float target, float rate, float momentum) {
    auto& [w, w_step, unused_o, unused_d, b, b_step] = network;
    o[0] = x;
    for (std::size_t l = 0; l < w.size(); ++l) {
      o[l + 1] = b[l];
      o[l + 1].noalias() += w[l] * o[l];
      o[l + 1] = activation(o[l + 1]);
    }
    const float error = target - o.back()(0);
    sse += error * error;
    d.back() = error * (0.25f - o.back().array().square());
    for (std::size_t l = w.size() - 1; l > 0; --l) {
      d[l - 1].noalias() = w[l].transpose() * d[l];
      d[l - 1].array() *= 0.25f - o[l].array().square();
    }
    for (std::size_t l = 0; l < w.size(); ++l) {
      w_step[l] = momentum * w_step[l] + (rate * d[l]) * o[l].transpose();
      b_step[l] = momentum * b_step[l] + rate * d[l];
      w[l] += w_step[l];
      b[l] += b_step[l];
    }
  }

  EigenNetwork network;
  std::vector<Eigen::VectorXf> o, d;
  float sse = 0;
};

#ifdef TACTEL_FANN
/// FANN's incremental training: the same rule but for the derivative, which it clips, and an output in (-1, 1); the
/// same work.
class FannOnline {
 public:
  explicit FannOnline(const nn::Topology& topology) {
    std::vector<unsigned> widths(topology.widths().begin(), topology.widths().end());
    network_ = fann_create_standard_array(static_cast<unsigned>(widths.size()), widths.data());
    fann_set_activation_function_hidden(network_, FANN_SIGMOID_SYMMETRIC);
    fann_set_activation_function_output(network_, FANN_SIGMOID_SYMMETRIC);
    fann_set_training_algorithm(network_, FANN_TRAIN_INCREMENTAL);
    fann_set_learning_rate(network_, 0.1f);
    fann_set_learning_momentum(network_, 0.9f);
  }
  ~FannOnline() { fann_destroy(network_); }
  FannOnline(const FannOnline&) = delete;
  FannOnline& operator=(const FannOnline&) = delete;
  void learn(const float* x, float target) { fann_train(network_, const_cast<float*>(x), &target); }

 private:
  fann* network_;
};
#endif

/// Calls body(i) for i = 0 ... count - 1 on so many threads; each draws the next.
template <class Body>
void on_threads(int threads, int count, const Body& body) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i; (i = next++) < count;) body(i);
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

}  // namespace tactel::bench
