// SPDX-License-Identifier: LGPL-2.1-or-later
// Replacements for functions that a program, its libraries and OpenCV call. They fail on demand. Include this in one
// source of a program, or of a library that is loaded first (LD_PRELOAD).
#pragma once

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

enum Kind { operator_new, opencv_allocation, thread_start, kinds };

/// How many calls of a kind still succeed; below zero, all do. `lasting`: after the first failure, all calls fail.
std::atomic<long> left[kinds] = {-1, -1, -1};
std::atomic<long> calls[kinds];
std::atomic<bool> lasting = false, counting = false;

bool fails(Kind kind) {
  if (!counting) return false;
  ++calls[kind];
  long now = left[kind];
  while (now >= 0) {
    if (now == 0 && lasting) return true;
    if (left[kind].compare_exchange_weak(now, now - 1)) return now == 0;
  }
  return false;
}

/// OpenCV's own allocations succeed, except pictures: its SIFT (4.6) throws from a destructor when one fails, and no
/// caller can help that.
bool is_of_opencv(void *caller) {
  Dl_info info;
  return dladdr(caller, &info) && info.dli_fname && std::strstr(info.dli_fname, "libopencv");
}

void *allocate_or_null(std::size_t size, std::size_t alignment, void *caller) noexcept {
  if (counting && !is_of_opencv(caller) && fails(operator_new)) return nullptr;
  return alignment ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                   : std::malloc(size ? size : 1);
}

void *allocate(std::size_t size, std::size_t alignment, void *caller) {
  void *memory = allocate_or_null(size, alignment, caller);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Not inlined: the return address must be the caller's, and g++ 12 reports a mismatch if it inlines only one of new and
// delete.
[[gnu::noinline]] void *operator new(std::size_t size) {
  return allocate(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size) {
  return allocate(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new(std::size_t size, std::align_val_t a) {
  return allocate(size, static_cast<std::size_t>(a), __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size, std::align_val_t a) {
  return allocate(size, static_cast<std::size_t>(a), __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new(std::size_t size, const std::nothrow_t &) noexcept {
  return allocate_or_null(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size, const std::nothrow_t &) noexcept {
  return allocate_or_null(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void operator delete(void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

// A sanitizer's own version, where the program has one. The C library's would start threads that the sanitizer doesn't
// know, and clang 19's ends the program when such a thread is joined.
extern "C" [[gnu::weak]] int __interceptor_pthread_create(pthread_t *, const pthread_attr_t *, void *(*)(void *),
                                                          void *);

extern "C" int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *data) {
  static const auto real = __interceptor_pthread_create
                               ? &__interceptor_pthread_create
                               : reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return fails(thread_start) ? EAGAIN : real(thread, attributes, run, data);
}
