"""What tests share: cases, comparisons, and programs that tests run in processes of their own."""
