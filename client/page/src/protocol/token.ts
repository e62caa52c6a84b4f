import {keep, recall} from "../base/kept";

/// The token by which the gateway authorises this page, if it requires one.  It comes in the
/// fragment of the page's address, `#token=…`, which browsers never send; it is removed from the
/// address at once, and kept for this tab only.
const kKept = "palpate.token";
const kFragment = "token";
const kSubprotocol = "palpate.token.";
/// Fits a header and a subprotocol unescaped.
const kToken = /^[A-Za-z0-9_.~-]{1,200}$/;

export class AccessToken {
  private value = "";

  constructor() {
    const kept = recall("sessionStorage", kKept) ?? "";
    if (kToken.test(kept)) this.value = kept;
    this.takeFromAddress();
  }

  /// Takes the token out of the address; returns whether there was one.
  takeFromAddress(): boolean {
    const url = new URL(location.href);
    const fragment = new URLSearchParams(url.hash.replace(/^#/, ""));
    const given = fragment.get(kFragment);
    if (given === null) return false;
    fragment.delete(kFragment);
    url.hash = fragment.toString();
    history.replaceState(null, "", url);
    if (!kToken.test(given)) return false;
    this.value = given;
    keep("sessionStorage", kKept, given);
    return true;
  }

  /// Headers for fetch.
  get headers(): Record<string, string> {
    return this.value === "" ? {} : {Authorization: `Bearer ${this.value}`};
  }
  /// Subprotocols for a WebSocket, whose headers a page cannot set.
  protocols(offered: readonly string[]): string[] {
    return this.value === "" ? [...offered] : [...offered, kSubprotocol + this.value];
  }
}
