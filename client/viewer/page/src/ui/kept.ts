type Where = "localStorage" | "sessionStorage";

// A browser that keeps nothing for this page (private windows) is no reason to fail: what it was to keep
// serves until the page goes.

export function recall(where: Where, key: string): string | null {
  try {
    return globalThis[where].getItem(key);
  } catch {
    return null;
  }
}

export function keep(where: Where, key: string, value: string): void {
  try {
    globalThis[where].setItem(key, value);
  } catch {
    return;
  }
}
