import {say} from "../messages/say";
import {readBundle, type SceneModel} from "../model/bundle";

/// A scene and the tag of the bytes that it was read from.
export interface FetchedScene {
  readonly tag: string;
  readonly model: SceneModel;
}

/// The scene's bundle over HTTP, which the browser keeps and asks for anew only by its tag.
/// @param headers  with the token, where there is one
/// @param have     what the page shows already; given back as it is where nothing has changed
/// Throws with a sentence for the reader.
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

/// What a server does that serves nothing yet.
export interface Compiling {
  readonly scene: string;
  readonly stage: string;
  readonly done: number; // 0 to 1
}

/// What the gateway says of itself, as far as the page uses it: both are of one version.
export interface Health {
  readonly scenes: readonly string[];
  readonly server_run: string;
  readonly server_lives: boolean; // the one that it last heard
  readonly compiling: Compiling | null;
  readonly viewers: number;
  readonly max_viewers: number;
}

/// undefined where no gateway answers; "token" where it wants one, or another one.
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
