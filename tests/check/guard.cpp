// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

GST_DEBUG_CATEGORY_STATIC(guard_debug);

namespace {

using testing::HasSubstr;

const csd::Guard guard(guard_debug, "Out of memory.", "It failed", "Do something.");

class Guard : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    gst_init(nullptr, nullptr);
    GST_DEBUG_CATEGORY_INIT(guard_debug, "csdguard", 0, nullptr);
    gst_debug_category_set_threshold(guard_debug, GST_LEVEL_ERROR);
  }
  static void TearDownTestSuite() { gst_deinit(); }
  Guard() : element_(gst_bin_new("element")), bus_(gst_bus_new()) {
    gst_object_ref_sink(element_);
    gst_element_set_bus(element_, bus_);
  }
  ~Guard() override {
    gst_element_set_bus(element_, nullptr);
    gst_object_unref(bus_);
    gst_object_unref(element_);
  }

  /// The debug text of the error on the bus.
  std::string debug_text() {
    GstMessage *message = gst_bus_pop_filtered(bus_, GST_MESSAGE_ERROR);
    if (!message) return "no error";
    g_autoptr(GError) error = nullptr;
    g_autofree gchar *debug = nullptr;
    gst_message_parse_error(message, &error, &debug);
    gst_message_unref(message);
    return debug;
  }

  GstElement *element_;
  GstBus *bus_;
};

std::string place(int line, const char *function) {
  return "guard.cpp(" + std::to_string(line) + "): " + function + " ():";
}

/// As a vmethod of an element.
int fails(gpointer element) {
  guard.posted(element, [] { throw std::runtime_error("planted"); });
  return __LINE__ - 1;
}

int fails_itself(gpointer element) {
  guard.post(element, *csd::guarded([] { throw std::runtime_error("planted"); }));
  return __LINE__ - 1;
}

int fails_quietly(gpointer element) {
  guard.logged(element, [] { throw std::runtime_error("planted"); });
  return __LINE__ - 1;
}

void note(GstDebugCategory *category, GstDebugLevel, const gchar *file, const gchar *function, gint line, GObject *,
          GstDebugMessage *message, gpointer noted) {
  if (category == guard_debug)
    *static_cast<std::string *>(noted) =
        std::string(file) + "(" + std::to_string(line) + "): " + function + " (): " + gst_debug_message_get(message);
}

TEST_F(Guard, AnErrorNamesThePlaceThatFailed) {
  const int line = fails(element_);
  EXPECT_THAT(debug_text(), HasSubstr("tests/check/" + place(line, "fails")));
  const int other = fails_itself(element_);
  EXPECT_THAT(debug_text(), HasSubstr("tests/check/" + place(other, "fails_itself")));
}

TEST_F(Guard, ALogNamesThePlaceThatFailed) {
  std::string noted;
  // In brackets, because clang finds fault with the macros of these names.
  (gst_debug_add_log_function)(note, &noted, nullptr);
  const int line = fails_quietly(element_);
  (gst_debug_remove_log_function)(note);
  EXPECT_THAT(noted, HasSubstr(place(line, "fails_quietly") + " planted"));
}

}  // namespace
