import {test} from "vitest";

import {kHasChromium} from "./browser";

/// A test in a browser; skipped, with a line that ctest looks for, where there is none.
export const browserTest = test.skipIf(!kHasChromium);
if (!kHasChromium) {
  console.log("SKIPPED: chromium is missing; deploy/setup --for tests installs it");
}
