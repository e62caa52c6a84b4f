import {say} from "../messages/say";
import {readBundle, type SceneModel} from "../model/bundle";

/// A scene, with the ETag of the bytes that it was read from.
export interface FetchedScene {
  readonly tag: string;
  readonly model: SceneModel;
}

/// Fetches the scene's bundle over HTTP; the browser caches it and revalidates by its ETag.
/// @param headers  with the token, if there is one
/// @param have     what the page already has; returned if nothing has changed
/// Throws an error whose message is for the reader.
export async function fetchScene(
  name: string,
  headers: Record<string, string>,
  have?: FetchedScene,
): Promise<FetchedScene> {
  const path = `scene/${encodeURIComponent(name)}.bundle`;
  const response = await fetch(path, {cache: "no-cache", headers});
  if (response.status === 404) {
    throw new Error(say("scene.not_yet", {scene: name}));
  }
  if (!response.ok) {
    const status = String(response.status);
    throw new Error(say("scene.not_fetched", {scene: name, status}));
  }
  const tag = response.headers.get("ETag") ?? "";
  if (have && tag !== "" && tag === have.tag) {
    await response.body?.cancel();
    return have;
  }
  return {tag, model: readBundle(new Uint8Array(await response.arrayBuffer()))};
}

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
