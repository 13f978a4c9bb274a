// Numbers as one says them.
export const meters = (value: number, digits = 1): string => `${value.toFixed(digits)} m`;

/** A time as the report writes it: `43.1 s`, `103 s`, `3 min 13 s`. */
export function seconds(value: number): string {
  const whole = Math.round(value);
  if (value < 99.95) return `${value.toFixed(1)} s`;
  if (value < 119.5) return `${whole} s`;
  return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
}

export const share = (value: number): string => `${+(100 * value).toFixed(1)} %`;

/** What the numbers of a survey mean, where their names do not say it. */
export const SURVEY_HELP: Record<string, string> = {
  height_above_ground: "Above the highest ground that is seen, at least; over ground that is not flat up to 15 % more",
  front_overlap: "Share of a photo that the next one shows too, at least",
  side_overlap: "Share of a photo that those of the next line show too, at least",
  turns_outside: "How far beyond the area the vehicle may be told to fly to turn",
  flights: "Left empty: as few as the battery is enough for, each with its reserve",
};
