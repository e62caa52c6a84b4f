import {readBundle, type SceneModel} from "../model/bundle";
import {parseObject} from "./decoder";

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
    throw new Error(`The gateway does not have the scene '${name}' yet.`);
  }
  if (!response.ok) {
    throw new Error(`The scene '${name}' could not be fetched (HTTP ${response.status}).`);
  }
  const tag = response.headers.get("ETag") ?? "";
  if (have && tag !== "" && tag === have.tag) {
    await response.body?.cancel();
    return have;
  }
  return {tag, model: readBundle(new Uint8Array(await response.arrayBuffer()))};
}

/// What the gateway says of itself.
export interface Health {
  readonly scenes: readonly string[];
  readonly serverRun: string;
  readonly full: boolean; // takes no more viewers
  readonly serverLives: boolean; // the one that it last heard
  readonly compiling: Compiling | undefined;
}

/// What a server does that serves nothing yet.
export interface Compiling {
  readonly scene: string;
  readonly stage: string;
  readonly done: number; // 0 to 1
}

function toCompiling(value: unknown): Compiling | undefined {
  if (typeof value !== "object" || value === null) return undefined;
  const {scene, stage, done} = value as Record<string, unknown>;
  if (typeof scene !== "string" || typeof stage !== "string" || typeof done !== "number") {
    return undefined;
  }
  return {scene, stage, done};
}

/// undefined where it does not answer; "token" where it wants one, or another one.
export async function fetchHealth(
  withinMs: number,
  headers: Record<string, string>,
): Promise<Health | "token" | undefined> {
  try {
    const signal = AbortSignal.timeout(withinMs);
    const response = await fetch("healthz", {cache: "no-store", signal, headers});
    if (response.status === 401) return "token";
    if (!response.ok) return undefined;
    const said = parseObject(await response.text());
    const {scenes, server_run: run, viewers, max_viewers: most} = said ?? {};
    const {server_lives: lives, compiling} = said ?? {};
    return {
      scenes: Array.isArray(scenes) ? scenes.filter((name) => typeof name === "string") : [],
      serverRun: typeof run === "string" ? run : "0",
      serverLives: lives !== false, // a gateway of before does not say
      compiling: toCompiling(compiling),
      full: typeof viewers === "number" && typeof most === "number" && viewers >= most,
    };
  } catch {
    return undefined;
  }
}
