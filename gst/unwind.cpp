// SPDX-License-Identifier: LGPL-2.1-or-later
// Two libraries of a process may unwind C++ exceptions: libgcc_s, and libunwind, which GStreamer brings along and which
// has functions of the same names. Python's `gi` makes it global: where a program imports cv2, then gi, libstdc++
// throws by libgcc_s, and what is loaded later goes on by libunwind, at the first destructor on the way. The process
// aborts or crashes (seen, Debian 12; Debian 13's GStreamer needs no libunwind). So going on is left to the library
// that threw. Hidden: of the module that it is linked into alone.
//
// Which one throws is settled where libstdc++ is loaded, not where we are linked. What else was tried, in every order
// of cv2, gi and a module of ours (tests/python/imports_test.py):
// * No exception across a frame: one std::string between throw and catch is enough. The plugin goes on in 396 places.
// * -static-libgcc, its symbols hidden: always libgcc's way. Right after cv2; aborts where gi came first.
// * -static-libstdc++ as well: what OpenCV throws, by the other libstdc++, crashes in each order.
// * -Bsymbolic, a version script, a dynamic list, libgcc_s first of the libraries: as without. What is global is looked
//   up before them, and libunwind's functions, which have no versions, match any.
// * Raising anew by _Unwind_Resume_or_Rethrow, without private fields: right after cv2, which brings libunwind itself.
//   Crashes after any other module in C++: libstdc++ reads the context of the library that it was loaded with.
// * An order to import in: gi first works, and cv2 first is the order of the alphabet.
// Beyond help here: after another module in C++ and gi, OpenCV's own frames go on by libunwind.
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
