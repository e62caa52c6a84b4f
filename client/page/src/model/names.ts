/// The names of the people at the stations, which have names in Latin letters only.
const names = new Map<string, string>();

/// Names told earlier stay: a recording of somebody who has left still says whose it is.
export function tellNames(told: Iterable<readonly [station: string, name: string]>): void {
  for (const [station, name] of told) names.set(station, name);
}

/// Returns the name of the person at a station; that of the station if nobody is known there.
export const nameOf = (station: string): string => names.get(station) ?? station;
