// SPDX-License-Identifier: Apache-2.0
#include "host/device/buffer.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

#include "host/device/opencl.h"

namespace tactel::host {
namespace {

// A page: enough for every vector type, and required for zero copy.
constexpr std::align_val_t alignment{4096};

struct FreeAligned {
  void operator()(void* memory) const { ::operator delete(memory, alignment); }
};

}  // namespace

struct RawBuffer::State {
  Device device;
  std::unique_ptr<void, FreeAligned> host;  ///< zero copy: what kernels work on; freed after the buffer below
  cl::Buffer buffer;
  cl::CommandQueue queue;  ///< for transfers; none with zero copy
  std::uint64_t id;

  State(const Device& device, std::size_t bytes) : device(device) {
    static std::atomic<std::uint64_t> made = 0;
    id = ++made;
    if (device.info().zero_copy) {
      host.reset(::operator new(bytes, alignment));
      buffer = cl::Buffer(device.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, host.get());
    } else {
      buffer = cl::Buffer(device.context(), CL_MEM_READ_WRITE, bytes);
      queue = device.make_queue();
      if (device.poisons()) {
        queue.enqueueFillBuffer(buffer, cl_uchar{0xff}, 0, bytes);
        queue.finish();
      }
    }
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
    translated(state_->device.info().name, [&] {
      state_->queue.enqueueWriteBuffer(state_->buffer, CL_TRUE, offset, bytes, from);
      state_->queue.finish();  // a blocking write may return when `from` is copied: other queues would read the old
    });
}

void RawBuffer::read(void* to, std::size_t offset, std::size_t bytes) const {
  check_range(offset, bytes);
  if (bytes == 0) return;
  if (state_->host)
    std::memcpy(to, static_cast<const char*>(state_->host.get()) + offset, bytes);
  else
    translated(state_->device.info().name,
               [&] { state_->queue.enqueueReadBuffer(state_->buffer, CL_TRUE, offset, bytes, to); });
}

void* RawBuffer::map(MapFor use) const {
  if (state_->host) return state_->host.get();
  const cl_map_flags flags = use == MapFor::reading   ? CL_MAP_READ
                             : use == MapFor::writing ? CL_MAP_WRITE_INVALIDATE_REGION
                                                      : CL_MAP_READ | CL_MAP_WRITE;
  return translated(state_->device.info().name, [&] {
    return state_->queue.enqueueMapBuffer(state_->buffer, CL_TRUE, flags, 0, std::max<std::size_t>(bytes_, 1));
  });
}

void RawBuffer::unmap(void* host) const {
  if (state_->host) return;
  translated(state_->device.info().name, [&] {
    state_->queue.enqueueUnmapMemObject(state_->buffer, host);
    state_->queue.finish();
  });
}

const cl::Buffer& RawBuffer::cl_buffer() const {
  if (!state_) throw std::logic_error("a buffer without a device");
  return state_->buffer;
}

}  // namespace tactel::host
