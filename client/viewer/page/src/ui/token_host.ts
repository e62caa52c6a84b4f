import type {TokenHost} from "../protocol/token";

/// Of this tab.  A browser that keeps nothing forgets the token with the page.
export const browserTokenHost: TokenHost = {
  get fragment() {
    return location.hash;
  },
  setFragment(fragment) {
    const url = new URL(location.href);
    url.hash = fragment;
    history.replaceState(null, "", url);
  },
  recall(key) {
    try {
      return sessionStorage.getItem(key);
    } catch {
      return null;
    }
  },
  keep(key, value) {
    try {
      sessionStorage.setItem(key, value);
    } catch {
      // It serves until the page is loaded anew.
    }
  },
};
