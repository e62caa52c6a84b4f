import {keep, recall} from "../ui/kept";

/// The token by which a gateway knows who asks, where it asks for one.  It comes in the fragment of
/// the page's address, `#token=…`, which browsers send to nobody; it is taken out of the address at
/// once, and kept for this tab alone.
const kKept = "palpate.token";
const kFragment = "token";
const kSubprotocol = "palpate.token.";
/// What fits a header and a subprotocol as it is.
const kToken = /^[A-Za-z0-9_.~-]{1,200}$/;

export class AccessToken {
  private value = "";

  constructor() {
    const kept = recall("sessionStorage", kKept) ?? "";
    if (kToken.test(kept)) this.value = kept;
    this.takeFromAddress();
  }

  /// Takes the token out of the address; true where there was one.
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

  /// For what is fetched.
  get headers(): Record<string, string> {
    return this.value === "" ? {} : {Authorization: `Bearer ${this.value}`};
  }
  /// For a WebSocket, which takes no headers of a page's.
  protocols(offered: readonly string[]): string[] {
    return this.value === "" ? [...offered] : [...offered, kSubprotocol + this.value];
  }
}
