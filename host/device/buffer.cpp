// SPDX-License-Identifier: Apache-2.0
#include "host/device/buffer.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <type_traits>

#include "host/device/built_programs.h"

namespace tactel::host {
namespace {

// A page: enough for every vector type, and required for zero copy.
constexpr std::align_val_t alignment{4096};

struct FreeAligned {
  void operator()(void* memory) const { ::operator delete(memory, alignment); }
};

/// The share of a device's memory that spare buffers may take.
constexpr std::size_t spare_share = 8;

/// Sizes are rounded up by an eighth at most, so that a launch finds the buffers of another of like size.
std::size_t rounded(std::size_t bytes) {
  const std::size_t step = std::max<std::size_t>(std::bit_floor(bytes) / 8, 64);
  return (bytes + step - 1) / step * step;
}

}  // namespace

struct RawBuffer::State {
  Device device;
  std::unique_ptr<void, FreeAligned> host;  ///< zero copy: what kernels work on; freed after the buffer below
  cl::Buffer buffer;
  std::uint64_t id;
  std::size_t bytes;

  State(const Device& device, std::size_t wanted)
      : device(device), bytes(device.info().zero_copy ? wanted : rounded(wanted)) {
    static std::atomic<std::uint64_t> made = 0;
    id = ++made;
    if (device.info().zero_copy) {
      host.reset(::operator new(bytes, alignment));
      buffer = cl::Buffer(device.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, host.get());
    } else {
      auto& memory = device.built_programs().memory;
      const std::lock_guard lock(memory.mutex);
      if (auto spare = memory.spare.extract(bytes))
        buffer = std::move(spare.mapped()), memory.bytes -= bytes;
      else
        check_size(), buffer = cl::Buffer(device.context(), CL_MEM_READ_WRITE, bytes);
      if (device.poisons())
        transfer([&](cl::CommandQueue& queue) {
          queue.enqueueFillBuffer(buffer, cl_uchar{0xff}, 0, bytes);
          queue.finish();
        });
    }
  }
  ~State() {
    if (host) return;
    auto& memory = device.built_programs().memory;
    const std::lock_guard lock(memory.mutex);
    try {
      if (memory.bytes + bytes > device.cl_device().getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>() / spare_share)
        memory.spare.clear(), memory.bytes = 0;
      memory.spare.emplace(bytes, std::move(buffer));
      memory.bytes += bytes;
    } catch (const std::exception&) {  // it is released
    }
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Drivers answer a buffer that is too large in their own ways, some at its first use.
  void check_size() const {
    const std::size_t most = device.cl_device().getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
    if (bytes > most)
      throw DeviceError("clCreateBuffer", std::to_string(bytes >> 20) + " MB in one buffer", device.info().name,
                        "the device allows " + std::to_string(most >> 20) + " MB: take fewer contacts or rows at once");
  }

  /// Calls `use` with the queue of transfers, one thread at a time: a blocking call of PoCL's `basic` returns although
  /// its command waits for another thread's in the same queue.
  template <class Use>
  std::invoke_result_t<Use, cl::CommandQueue&> transfer(const Use& use) const {
    auto& memory = device.built_programs().memory;
    const std::lock_guard lock(memory.transfer);
    if (!memory.queue()) memory.queue = device.make_queue();
    return translated(device.info().name, [&] { return use(memory.queue); });
  }
};

RawBuffer::RawBuffer(const Device& device, std::size_t bytes)
    : state_(translated(device.info().name,
                        [&] { return std::make_shared<State>(device, std::max<std::size_t>(bytes, 1)); })),
      bytes_(bytes) {}

std::uint64_t RawBuffer::id() const { return state_ ? state_->id : 0; }

void RawBuffer::check_range(std::size_t offset, std::size_t bytes) const {
  if (offset > bytes_ || bytes > bytes_ - offset) throw std::out_of_range("outside the buffer");
}

void RawBuffer::write(const void* from, std::size_t offset, std::size_t bytes) {
  check_range(offset, bytes);
  if (bytes == 0) return;
  if (state_->host)
    std::memcpy(static_cast<char*>(state_->host.get()) + offset, from, bytes);
  else
    state_->transfer([&](cl::CommandQueue& queue) {
      queue.enqueueWriteBuffer(state_->buffer, CL_TRUE, offset, bytes, from);
      queue.finish();  // a blocking write may return when `from` is copied: other queues would read the old
    });
}

void RawBuffer::read(void* to, std::size_t offset, std::size_t bytes) const {
  check_range(offset, bytes);
  if (bytes == 0) return;
  if (state_->host)
    std::memcpy(to, static_cast<const char*>(state_->host.get()) + offset, bytes);
  else
    state_->transfer(
        [&](cl::CommandQueue& queue) { queue.enqueueReadBuffer(state_->buffer, CL_TRUE, offset, bytes, to); });
}

void* RawBuffer::map(MapFor use) const {
  if (state_->host) return state_->host.get();
  const cl_map_flags flags = use == MapFor::reading   ? CL_MAP_READ
                             : use == MapFor::writing ? CL_MAP_WRITE_INVALIDATE_REGION
                                                      : CL_MAP_READ | CL_MAP_WRITE;
  return state_->transfer([&](cl::CommandQueue& queue) {
    return queue.enqueueMapBuffer(state_->buffer, CL_TRUE, flags, 0, std::max<std::size_t>(bytes_, 1));
  });
}

void RawBuffer::unmap(void* host) const {
  if (state_->host) return;
  state_->transfer([&](cl::CommandQueue& queue) {
    queue.enqueueUnmapMemObject(state_->buffer, host);
    queue.finish();
  });
}

const cl::Buffer& RawBuffer::cl_buffer() const {
  if (!state_) throw std::logic_error("a buffer without a device");
  return state_->buffer;
}

}  // namespace tactel::host
