type Where = "localStorage" | "sessionStorage";

// Storage that also works in a browser that stores nothing (private windows): values are then kept
// until the page closes.

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
