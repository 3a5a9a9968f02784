// SPDX-License-Identifier: Apache-2.0
#include "host/device/launcher.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
#include <shared_mutex>

#include "host/support/interrupt.h"
#include "kernels/shared/group.h"

namespace tactel::host {
namespace {

constexpr std::size_t widest_gpu_launch = std::size_t{1} << 24;
constexpr std::size_t gpu_local_size = 64;  ///< where the kernel's private memory allows so many

/// Held alone by a compilation, and with others by the launches that must not go beside one:
/// Launcher::compiles_sizes().
std::shared_mutex launches;

// Launches of another kernel than the one before, in all launchers: what was not launched for `kept_kernels` of them
// PoCL may have forgotten, and what was made since as well. It keeps 128, of some programs two a kernel.
constexpr std::uint64_t kept_kernels = 100;
std::atomic<std::uint64_t> changes = kept_kernels;
std::atomic<const void*> latest = nullptr;

}  // namespace

Launcher::Launcher(const Device& device, int threads) : device_(device) {
  for (int i = 0; i < threads; ++i) queues_.push_back(device.make_queue());
}

std::size_t Launcher::widest_launch() const {
  return device_.info().type == DeviceType::cpu ? widest_cpu_launch : widest_gpu_launch;
}

std::size_t Launcher::required_size(const Device& device, const cl::Kernel& kernel) {
  return std::max<std::size_t>(1, kernel.getWorkGroupInfo<CL_KERNEL_COMPILE_WORK_GROUP_SIZE>(device.cl_device())[0]);
}

std::size_t Launcher::local_size(const cl::Kernel& kernel) const {
  const std::size_t required = required_size(device_, kernel);
  if (required > 1 || device_.info().type == DeviceType::cpu) return required;
  const std::size_t most = kernel.getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(device_.cl_device());
  return std::bit_floor(std::clamp<std::size_t>(most, 1, gpu_local_size));
}

void Launcher::enqueue(cl::CommandQueue& queue, cl::Kernel& kernel, std::size_t first, std::size_t global,
                       std::size_t local) {
  if (global == 0) return;
  kernel.setArg(0, static_cast<cl_uint>(first));
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(global), cl::NDRange(local));
}

// A processor has one local size. PoCL in the place of a GPU compiles a kernel for each, and aborts where another
// thread launches it then.
bool Launcher::compiles_sizes() const { return is_pocl(device_.info()) && device_.info().type != DeviceType::cpu; }

void Launcher::compile(Launch::State& launch) {
  if (launch.compiled) return;
  launch.local = translated(device_.info().name, [&] { return local_size(launch.kernels[0]); });
  if (launch.program.takes_group(launch.kernel)) {
    launch.widest = widest_launch();
    const std::size_t global = device_.info().type == DeviceType::cpu ? launch.widest : launch.local;
    compile(launch, global, launch.local);
  } else {
    device_.log(LogLevel::warning, launch.kernel + " lacks TAKE_GROUP: compiled at its first use, run group by group");
  }
  launch.used = changes += kept_kernels;
  launch.compiled = true;
}

void Launcher::remind(cl::CommandQueue& queue, Launch::State& launch, int thread) {
  if (device_.info().type != DeviceType::cpu || launch.widest == 1) return;
  if (latest.load(std::memory_order_relaxed) != &launch) {
    latest.store(&launch, std::memory_order_relaxed);
    ++changes;
  }
  const std::uint64_t now = changes.load(std::memory_order_relaxed);
  const std::atomic_ref used(launch.used);
  const std::uint64_t before = used.load(std::memory_order_acquire);
  if (now == before) return;
  if (now - before >= kept_kernels) {
    enqueue(queue, launch.kernels[thread], std::size_t{NO_GROUPS}, launch.widest, launch.local);
    queue.finish();
  }
  used.store(now, std::memory_order_release);
}

void Launcher::compile(Launch::State& launch, std::size_t global, std::size_t local) {
  const HeldSignals held(HeldSignals::handled);
  const std::lock_guard lock(launches);
  on_spare_queue([&](cl::CommandQueue& queue) {
    enqueue(queue, launch.kernels[0], std::size_t{NO_GROUPS}, global, local);
    queue.finish();
  });
  launch.local_sizes.insert(local);
}

// OpenCL's own offset stays zero: PoCL aborts when two threads launch a kernel with and without. On a GPU a ragged end
// goes in a launch of its own, as OpenCL 1.2 requires whole work-groups.
void Launcher::launch_on(cl::CommandQueue& queue, Launch::State& launch, int thread, std::size_t first,
                         std::size_t count) {
  remind(queue, launch, thread);
  for (const std::size_t end = first + count; first < end; first += count) {
    count = std::min(end - first, launch.widest);
    const std::size_t ragged = count % launch.local;
    std::shared_lock<std::shared_mutex> beside;
    if (compiles_sizes()) {
      if (ragged > 0 && launch.widest > 1 && !launch.local_sizes.contains(ragged)) compile(launch, ragged, ragged);
      beside = std::shared_lock(launches);
    }
    enqueue(queue, launch.kernels[thread], first, count - ragged, launch.local);
    enqueue(queue, launch.kernels[thread], first + count - ragged, ragged, ragged);
    if (beside) queue.finish();
  }
  queue.finish();
}

void Launcher::launch(Launch::State& launch, int thread, std::size_t first, std::size_t count) {
  translated(device_.info().name, [&] { launch_on(queues_[thread], launch, thread, first, count); });
}

void Launcher::launch_beside(Launch::State& launch, std::size_t first, std::size_t count) {
  on_spare_queue([&](cl::CommandQueue& queue) { launch_on(queue, launch, 0, first, count); });
}

template <class Use>
void Launcher::on_spare_queue(const Use& use) {
  translated(device_.info().name, [&] {
    cl::CommandQueue queue;
    {
      const std::lock_guard lock(spare_turn_);
      if (spare_.empty()) spare_.push_back(device_.make_queue());
      queue = std::move(spare_.back());
      spare_.pop_back();
    }
    use(queue);
    const std::lock_guard lock(spare_turn_);
    spare_.push_back(std::move(queue));
  });
}

}  // namespace tactel::host
