// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "host/device/device.h"
#include "host/support/errors.h"

namespace tactel::host {

/// What a map is for: a device with memory of its own copies only what is needed.
enum class MapFor {
  reading,
  writing,  ///< contents are undefined at first
  both
};

/// Bytes in device memory. On a zero-copy device they are aligned host memory that kernels use in place.
/// Elsewhere read, write and map move a copy. All calls block. Use Buffer<T>.
class RawBuffer {
 public:
  RawBuffer() = default;
  RawBuffer(const Device& device, std::size_t bytes);  ///< contents undefined; 0 bytes allowed
  void write(const void* from, std::size_t offset, std::size_t bytes);
  void read(void* to, std::size_t offset, std::size_t bytes) const;
  void* map(MapFor use) const;   ///< host address of all bytes, valid until unmap
  void unmap(void* host) const;  ///< changes are visible to the next launch
  const cl::Buffer& cl_buffer() const;
  std::size_t bytes() const { return bytes_; }
  std::uint64_t id() const;  ///< of the memory: that of copies, and of no other buffer

 private:
  void check_range(std::size_t offset, std::size_t bytes) const;
  struct State;
  std::shared_ptr<State> state_;
  std::size_t bytes_ = 0;
};

/// An array of T on the device. Copies share the memory. Pass it to Launch::bind and KernelArguments::set.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Host view of the whole array during its lifetime. It must end before the next launch that uses the buffer.
  class Mapping {
   public:
    explicit Mapping(const Buffer& buffer, MapFor use = MapFor::both)
        : raw_(buffer.raw_), view_(static_cast<T*>(raw_.map(use)), buffer.size()) {}
    ~Mapping() {
      try {
        raw_.unmap(view_.data());
      } catch (const DeviceError&) {  // the next call on this device reports it
      }
    }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    std::span<T> view() const { return view_; }
    T& operator[](std::size_t i) const { return view_[i]; }

   private:
    RawBuffer raw_;
    std::span<T> view_;
  };

  Buffer() = default;
  Buffer(const Device& device, std::size_t count) : raw_(device, count * sizeof(T)) {}
  Buffer(const Device& device, std::span<const T> from) : Buffer(device, from.size()) { write(from); }

  std::size_t size() const { return raw_.bytes() / sizeof(T); }
  void write(std::span<const T> from, std::size_t first = 0) {
    raw_.write(from.data(), first * sizeof(T), from.size_bytes());
  }
  void read(std::span<T> to, std::size_t first = 0) const { raw_.read(to.data(), first * sizeof(T), to.size_bytes()); }
  Mapping map(MapFor use = MapFor::both) const { return Mapping(*this, use); }
  const cl::Buffer& cl_buffer() const { return raw_.cl_buffer(); }
  std::uint64_t id() const { return raw_.id(); }

 private:
  RawBuffer raw_;
};

}  // namespace tactel::host
