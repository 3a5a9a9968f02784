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
Ranks::Ranks() {
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
#else
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
#endif

}  // namespace tactel::host
