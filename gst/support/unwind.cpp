// SPDX-License-Identifier: LGPL-2.1-or-later
// A process may contain two C++ unwinders: libgcc_s, and libunwind, which GStreamer depends on and which exports
// functions of the same names. Python's `gi` makes it global: if a program imports cv2, then gi, libstdc++ throws with
// libgcc_s, but libraries loaded later resume with libunwind, at the first destructor on the way. The process aborts or
// crashes (seen, Debian 12). So this function resumes with the library that threw. It is hidden: only the module it is
// linked into uses it.
//
// gst/meson.build compiles this file only where libgstreamer itself needs libunwind: Debian 12's (1.22) does, Debian
// 13's (1.26) doesn't. The file goes, with all that says beside_libunwind or unwind_source, once meson.build asks for
// GStreamer 1.26.
//
// Which one throws is decided when libstdc++ is loaded, not when we are linked. What else was tried, with cv2, gi and a
// module of ours in every order (tests/python/imports_test.py):
// * No exception across a frame: one std::string between throw and catch is enough. The plugin resumes in 396 places.
// * -static-libgcc with hidden symbols: always resumes with libgcc. Works after cv2; aborts after gi.
// * -static-libstdc++ as well: OpenCV's exceptions come from the other libstdc++ and crash in each order.
// * -Bsymbolic, a version script, a dynamic list, libgcc_s linked first: no effect. Global symbols are looked up
//   before them, and libunwind's functions are unversioned, so they match any version.
// * _Unwind_Resume_or_Rethrow, which needs no private fields: works after cv2, which brings libunwind itself. Crashes
//   after any other C++ module: libstdc++ reads the context of the library that it was loaded with.
// * An import order: gi first works, but cv2 comes first in the alphabet.
// Not fixed here: after another C++ module and gi, OpenCV's own frames resume with libunwind.
#ifndef __ARM_EABI__  // which resumes in another way
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

/// private_2 stores where the exception will be caught: libgcc_s stores the frame's address, which is in no object
/// file; libunwind stores the instruction's, which is in one. Forced unwinding, e.g. of an ending thread, has a
/// function in private_1 and always uses libgcc_s, because glibc does.
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
