"""From terms to Structured Text (IEC 61131-3): its text, its test block, its files for PLC projects."""
