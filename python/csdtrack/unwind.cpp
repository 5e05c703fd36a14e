// SPDX-License-Identifier: LGPL-2.1-or-later
// Two libraries of a Python process may unwind C++ exceptions: libgcc_s, and libunwind, which `gi` makes global with
// GStreamer and which has functions of the same names. Where OpenCV's module was imported first, then gi, libstdc++
// throws by libgcc_s while this module would go on by libunwind: the process aborts (seen, Debian 12). So going on is
// left to the library that threw. Hidden: this module's alone.
#include <dlfcn.h>

#include <cstdint>
#include <cstdlib>

namespace {

/// _Unwind_Exception of the Itanium C++ ABI, Exception Handling 1.2.
struct Header {
  std::uint64_t exception_class;
  void (*cleanup)(int, Header *);
  std::uint64_t private_1, private_2;
};
using Resume = void (*)(Header *);

/// Where the exception will be caught is kept in private_2: libgcc_s keeps the frame's address, which is in no object
/// file, libunwind the instruction's, which is in one. Forced unwinding, as of a thread that ends, has no such place,
/// and is libgcc_s's: glibc calls none other.
bool is_of_libunwind(const Header &header) {
  Dl_info info;
  return header.private_1 == 0 && dladdr(reinterpret_cast<const void *>(header.private_2), &info) != 0;
}

Resume resume_of(const char *library) {
  void *handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
  return handle ? reinterpret_cast<Resume>(dlsym(handle, "_Unwind_Resume")) : nullptr;
}

}  // namespace

extern "C" [[noreturn, gnu::visibility("hidden")]] void _Unwind_Resume(Header *header) {
  if (const Resume resume = resume_of(is_of_libunwind(*header) ? "libunwind.so.8" : "libgcc_s.so.1")) resume(header);
  std::abort();
}
