/// The progress of a server that does not serve yet.
export interface Compiling {
  readonly scene: string;
  readonly stage: string;
  readonly done: number; // 0 to 1
}

/// The gateway's report about itself, as far as the page uses it; both have the same version.
export interface Health {
  readonly scenes: readonly string[];
  readonly server_run: string;
  readonly server_lives: boolean; // the server heard last
  readonly compiling: Compiling | null;
  readonly viewers: number;
  readonly max_viewers: number;
}

/// Returns undefined if no gateway answers; "token" if it requires one, or another one.
export async function fetchHealth(
  withinMs: number,
  headers: Record<string, string>,
): Promise<Health | "token" | undefined> {
  try {
    const signal = AbortSignal.timeout(withinMs);
    const response = await fetch("healthz", {cache: "no-store", signal, headers});
    if (response.status === 401) return "token";
    if (!response.ok) return undefined;
    const health = (await response.json()) as Health;
    return Array.isArray(health.scenes) ? health : undefined;
  } catch {
    return undefined;
  }
}
