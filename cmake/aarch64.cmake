# SPDX-License-Identifier: Apache-2.0

# tactel::infer for 64-bit ARM, on another processor. Debian: g++-aarch64-linux-gnu; qemu-user-static runs its programs here.
#   cmake -B build-aarch64 -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64.cmake -DTACTEL_SIMULATE=OFF -DBUILD_SHARED_LIBS=OFF
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)  # QEMU needs no libraries of that processor
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
