import {type ReplayState, toReplayState} from "@page/protocol/messages";

/// What a gateway sends of a replay that plays, field by field of idl/replay.idl.
export const replayStateSent = <More extends object>(atS: number, more: More = {} as More) => ({
  replay: "ab",
  at_s: atS,
  rate: 1,
  sought: 1,
  playing: true,
  ended: false,
  request: "0",
  refusal: "",
  ...more,
});

/// The same, as the page has read it.
export const replayState = (atS: number, more: Partial<ReplayState> = {}): ReplayState => ({
  ...toReplayState(replayStateSent(atS)),
  ...more,
});
