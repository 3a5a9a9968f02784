// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace tactel::host {

/// The processes of one run: several under mpirun (where tactel was built with MPI), else this one alone. A
/// program creates one object, in the main thread. An exception that leaves its scope also stops the other
/// processes.
class Ranks {
 public:
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int rank() const { return rank_; }
  int count() const { return count_; }
  bool first() const { return rank_ == 0; }
  void barrier() const;
  /// Returns the sums over all processes, element by element.
  std::vector<double> sum(std::vector<double> values) const;
  /// The same of a struct whose members are all double.
  template <class Sums>
  Sums sum(const Sums& own) const {
    static_assert(std::is_trivially_copyable_v<Sums> && sizeof(Sums) % sizeof(double) == 0);
    std::vector<double> values(sizeof own / sizeof(double));
    std::memcpy(values.data(), &own, sizeof own);
    values = sum(std::move(values));
    Sums all;
    std::memcpy(static_cast<void*>(&all), values.data(), sizeof all);
    return all;
  }

 private:
  bool started_ = false;
  int rank_ = 0, count_ = 1;
};

}  // namespace tactel::host
