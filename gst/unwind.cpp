// SPDX-License-Identifier: LGPL-2.1-or-later
// Two libraries of a process may unwind C++ exceptions: libgcc_s, and libunwind, which GStreamer brings along and which
// has functions of the same names. Python's `gi` makes it global: where a program imports cv2, then gi, libstdc++
// throws by libgcc_s, and what is loaded later goes on by libunwind, at the first destructor on the way. The process
// aborts or crashes (seen, Debian 12). So going on is left to the library that threw. Hidden: of the module that it is
// linked into alone.
#ifndef __ARM_EABI__  // which has another way of going on
#include <dlfcn.h>

#include <cstdint>
#include <cstdlib>

namespace {

/// _Unwind_Exception of the Itanium C++ ABI, Exception Handling 1.2.
struct Header {
  std::uint64_t exception_class;
  void (*cleanup)(int, Header *);
  std::uintptr_t private_1, private_2;
};
using Resume = void (*)(Header *);

/// Where the exception will be caught is kept in private_2: libgcc_s keeps the frame's address, which is in no object
/// file, libunwind the instruction's, which is in one. Forced unwinding, as of a thread that ends, keeps a function in
/// private_1, and is libgcc_s's: glibc asks none other.
bool is_of_libunwind(const Header &header) {
  Dl_info info;
  return header.private_1 == 0 && dladdr(reinterpret_cast<const void *>(header.private_2), &info) != 0;
}

Resume resume_of(const char *library) {
  void *handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
  return reinterpret_cast<Resume>(dlsym(handle ? handle : RTLD_DEFAULT, "_Unwind_Resume"));
}

}  // namespace

// NOLINTNEXTLINE(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): the ABI's name
extern "C" [[noreturn, gnu::visibility("hidden")]] void _Unwind_Resume(Header *header) {
  if (const Resume resume = resume_of(is_of_libunwind(*header) ? "libunwind.so.8" : "libgcc_s.so.1")) resume(header);
  std::abort();
}
#endif
