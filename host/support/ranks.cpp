// SPDX-License-Identifier: Apache-2.0
#include "host/support/ranks.h"

#include <cstdlib>
#include <exception>

#ifdef TACTEL_MPI
#include <mpi.h>
#else
#include "host/support/errors.h"
#endif

namespace tactel::host {
namespace {

/// The variable that mpirun (Open MPI, MPICH and Slurm's srun) sets; null without it.
const char* set_by_mpirun() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"})
    if (std::getenv(name)) return name;
  return nullptr;
}

}  // namespace

#ifdef TACTEL_MPI
struct Ranks::Sending {
  MPI_Request request = MPI_REQUEST_NULL;
  std::string bytes;
};

Ranks::Ranks() : sending_(std::make_unique<Sending>()) {
  if (!set_by_mpirun()) return;
  int given = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  started_ = true;
}

Ranks::~Ranks() {
  if (!started_) return;
  if (std::uncaught_exceptions() > 0) return;  // main says what it was, then ends the run by its exit code
  MPI_Finalize();
}

void Ranks::barrier() const {
  if (started_) MPI_Barrier(MPI_COMM_WORLD);
}

std::vector<double> Ranks::sum(std::vector<double> values) const {
  if (started_)
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return values;
}

void Ranks::send(int rank, std::string bytes) {
  if (!started_) return;
  // The analyzer sees no earlier call: NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker)
  MPI_Wait(&sending_->request, MPI_STATUS_IGNORE);
  sending_->bytes = std::move(bytes);
  MPI_Isend(sending_->bytes.data(), static_cast<int>(sending_->bytes.size()), MPI_BYTE, rank, 0, MPI_COMM_WORLD,
            &sending_->request);
}

std::optional<std::string> Ranks::receive() const {
  if (!started_) return {};
  int waits = 0, size = 0;
  MPI_Message message = MPI_MESSAGE_NULL;
  MPI_Status status;
  MPI_Improbe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &waits, &message, &status);
  if (!waits) return {};
  MPI_Get_count(&status, MPI_BYTE, &size);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  MPI_Mrecv(bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
  return bytes;
}
#else
struct Ranks::Sending {};
Ranks::Ranks() {
  if (const char* name = set_by_mpirun())
    throw ConfigError(
        "environment", name, std::getenv(name),
        "unset, without mpirun: this tactel was built without MPI, and each process would do all; the Debian "
        "package tactel-mpi has a program with MPI, `mpirun tactel-mpi`");
}
Ranks::~Ranks() = default;
void Ranks::barrier() const {}
std::vector<double> Ranks::sum(std::vector<double> values) const { return values; }
void Ranks::send(int, std::string) {}
std::optional<std::string> Ranks::receive() const { return {}; }
#endif

}  // namespace tactel::host
